from dataclasses import replace

import pytest

from rtkit.deployment.system import KnownType
from rtkit.deployment.wanted import STAND_IN_SLAVE, wanted
from rtkit.errors import Malformed
from rtkit.profile.common import ExtensionProperty
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import ExecutionKind, Polarity, PortType
from rtkit.rtc.profiles import PortRef


def only(system):
    (component,) = system.components
    return component


@pytest.mark.parametrize(
    ("uri", "name", "path"),
    [
        ("localhost/Sink0.rtc", "localhost/Sink0.rtc", "/localhost/Sink0.rtc"),
        ("localhost:2809/Sink0.rtc", "localhost/Sink0.rtc", "/localhost:2809/Sink0.rtc"),
        ("127.0.0.1/a.host_cxt/S.rtc", "localhost/a.host_cxt/S.rtc", "/127.0.0.1/a.host_cxt/S.rtc"),
        ("box/Sink0.rtc", "localhost/Sink0.rtc", "/box/Sink0.rtc"),
        ("/localhost/Sink0.rtc", "localhost/Sink0.rtc", "/localhost/Sink0.rtc"),
        ("10.0.0.9/Sink0.rtc", "10.0.0.9/Sink0.rtc", "/10.0.0.9/Sink0.rtc"),
        ("", "localhost/Sink0.rtc", "/localhost/Sink0.rtc"),
        ("file://localhost/C:\\x.xml", "localhost/Sink0.rtc", "/localhost/Sink0.rtc"),
        ("Sink0.rtc", "localhost/Sink0.rtc", "/localhost/Sink0.rtc"),
        ("localhost/../Sink0.rtc", "localhost/Sink0.rtc", "/localhost/Sink0.rtc"),
        ("localhost/.rtc", "localhost/Sink0.rtc", "/localhost/Sink0.rtc"),
    ],
)
def test_names(make, uri, name, path):
    component = only(wanted(make.profile(make.component("Sink0", uri=uri)), "box"))
    assert (component.name, component.path) == (name, path)


def test_other_paths_are_told(make):
    system = wanted(make.profile(make.component("Sink0", uri="sink.xml")), "box")
    assert system.notes == (
        "Sink0: path 'sink.xml' is no name of a component: taken as /localhost/Sink0.rtc",
    )


def test_a_path_used_twice_becomes_two(make):
    twice = [make.component(name, uri="localhost/x.rtc") for name in ("Sink0", "Sink1")]
    system = wanted(make.profile(*twice), "box")
    assert [c.name for c in system.components] == ["localhost/x.rtc", "localhost/Sink1.rtc"]
    assert "used twice" in system.notes[0]


@pytest.mark.parametrize(
    ("how", "unknown"),
    [
        ({}, "10.0.0.9"),
        ({"stand_in": True}, ""),
        ({"host_map": {"10.0.0.9": "localhost"}}, ""),
        ({"host_map": {"10.0.0.8": "localhost"}}, "10.0.0.9"),
        ({"stand_ins": {"Sink0"}}, ""),
    ],
)
def test_hosts_that_nobody_knows(make, how, unknown):
    profile = make.profile(make.component("Sink0", uri="10.0.0.9/Sink0.rtc"))
    component = only(wanted(profile, "box", **how))
    assert (component.name, component.unknown_host) == ("10.0.0.9/Sink0.rtc", unknown)


def test_a_marked_stand_in_may_live_under_any_host(make):
    marked = make.component("Sink0", uri="10.0.0.9/Sink0.rtc", properties={"rtkit.stand-in": "yes"})
    assert only(wanted(make.profile(marked), "box")).unknown_host == ""


def test_hosts_cannot_be_mapped_to_hosts_without_manager(make):
    with pytest.raises(Malformed, match="cannot map a to b: no manager is known on b"):
        wanted(make.profile(), "box", host_map={"a": "b"})


def test_two_of_one_name_are_refused(make):
    twice = [make.component("Sink0", id=f"RTC:Me:test:{kind}:1.0") for kind in "AB"]
    with pytest.raises(Malformed, match="two components are named Sink0"):
        wanted(make.profile(*twice), "box")


def test_ports_lose_their_prefix_and_find_their_direction(make):
    stated = make.port("Std0.back", {"port.port_type": "DataOutPort"})
    component = make.component("Std0", ports=("Std0.feed", "wired", stated, "OutImage", "x"))
    system = wanted(
        make.profile(
            component,
            make.component("Sink0"),
            make.data("w", "Std0.wired", "Sink0.in", data_type="TimedShort"),
        ),
        "box",
    )
    ports = {port.name: port for port in system.components[0].ports}
    kinds = {name: port.port_type for name, port in ports.items()}
    assert kinds == {
        "feed": PortType.IN,
        "wired": PortType.OUT,
        "back": PortType.OUT,
        "OutImage": PortType.OUT,
        "x": PortType.IN,
    }
    assert ports["wired"].data_type == "TimedShort"
    assert ports["x"].data_type == ""


def test_a_connector_that_runs_backwards_is_turned(make):
    out = make.port("a", {"port.port_type": "DataOutPort"})
    into = make.port("b", {"port.port_type": "DataInPort"})
    parts = [make.component("X0", ports=(out,)), make.component("Y0", ports=(into,))]
    system = wanted(make.profile(*parts, make.data("w", "Y0.b", "X0.a")), "box")
    assert system.connectors[0].profile.ports == (PortRef("X0", "a"), PortRef("Y0", "b"))


@pytest.mark.parametrize("by", ["sets", "create"])
def test_a_port_that_a_composite_shows_is_wanted_at_its_member(make, by):
    said = {"sets": {"default": {"members": "Sink0"}}} if by == "sets" else {}
    told = {"properties": {"rtkit.create": "W?members=Sink0"}} if by == "create" else {}
    whole = make.component("W", ports=("Sink0.in", "Nobody.in"), **said, **told)
    parts = [make.component("Source0"), make.component("Sink0"), whole]
    wires = [make.data(id, "Source0.out", f"W.{id}.in") for id in ("Sink0", "Nobody")]
    system = wanted(make.profile(*parts, *wires), "box")
    ends = [wire.profile.ports[1] for wire in system.connectors]
    assert ends == [PortRef("Sink0", "in"), PortRef("W", "Nobody.in")]


def test_properties_of_connectors_win_over_attributes_and_references_go(make):
    told = {
        "dataport.subscription_type": "flush",
        "dataport.corba_cdr.inport_ior": "IOR:01",
        "x.inport_ref": "y",
        "port.Type.Name": "IOR:02",
        "POSITION": "{1:(1,2)}",
    }
    wire = make.data("w", "Source0.out", "Sink0.in", properties=told, interval=0.5)
    parts = [make.component("Source0"), make.component("Sink0", required=False)]
    (connector,) = wanted(make.profile(*parts, wire), "box").connectors
    assert connector.profile.properties == {
        "dataport.data_type": "IDL:RTC/TimedLong:1.0",
        "dataport.interface_type": "corba_cdr",
        "dataport.dataflow_type": "push",
        "dataport.subscription_type": "flush",
        "dataport.push_interval": "0.5",
        "POSITION": "{1:(1,2)}",
    }
    assert not connector.is_required


def test_create_strings_come_from_the_profile_first_then_from_what_is_known(make):
    known = {"RTC:Me:test:Sink:1.0": KnownType("RTC:Me:test:Sink:Python:1.0", "sink.py:init")}
    own = make.component(
        "Sink0", properties={"rtkit.create": "Sink?manager_name=s", "rtkit.module": "m.py"}
    )
    first = only(wanted(make.profile(own), "box", known_types=known))
    assert (first.create, first.module) == ("Sink?manager_name=s&instance_name=Sink0", "m.py")
    plain = only(wanted(make.profile(make.component("Sink0")), "box", known_types=known))
    assert plain.create == "RTC:Me:test:Sink:Python:1.0?instance_name=Sink0"
    assert plain.module == "sink.py:init"
    nobody = only(wanted(make.profile(make.component("Sink0")), "box"))
    assert (nobody.create, nobody.pattern) == ("", None)


def test_a_create_string_that_cannot_be_read_names_its_component(make):
    bad = make.component("Sink0", properties={"rtkit.create": "Sink?x"})
    with pytest.raises(Malformed, match=r"Sink0: rtkit\.create: option 'x' is not KEY=VALUE"):
        wanted(make.profile(bad), "box")


def test_stand_ins_have_what_the_profile_describes(make):
    component = make.component(
        "Sink0",
        sets={"default": {"a": "1"}, "__widget__": {"a": "text"}},
        active="other",
        contexts=(("Ec1", "PeriodicExecutionContext", 50.0), ("", "EVENT_DRIVEN", None)),
        services=("Sink0.srv",),
    )
    made = only(wanted(make.profile(component), "box", stand_in=True))
    pattern = made.pattern
    assert pattern.type.id == "RTC:Me:test:Sink:1.0"
    assert pattern.sets == {"default": {"a": "1"}, "__widget__": {"a": "text"}, "other": {}}
    assert pattern.active_set == "other"
    assert [(c.id, c.kind, c.rate) for c in pattern.contexts] == [
        ("Ec1", ExecutionKind.PERIODIC, 50.0),
        ("1", ExecutionKind.EVENT_DRIVEN, 0.0),
    ]
    assert [(p.name, p.port_type) for p in pattern.ports] == [
        ("in", PortType.IN),
        ("srv", PortType.SERVICE),
    ]
    options = parse_create(made.create).options
    assert options["manager_name"] == STAND_IN_SLAVE
    assert options["rtkit.kind.Ec1"] == "PeriodicExecutionContext"


def test_stand_ins_live_where_the_real_one_would(make):
    own = make.component("Sink0", properties={"rtkit.create": "Sink?manager_name=s&conf.a.b=1"})
    made = only(wanted(make.profile(own), "box", stand_in=True))
    assert parse_create(made.create).options["manager_name"] == "s"
    assert "conf.a.b" not in parse_create(made.create).options


def test_stand_ins_transmit_when_asked(make):
    script = {"rtkit.stand-in.out": '[1, {"data": 2}]'}
    own = make.component("Source0", properties=script)
    made = only(wanted(make.profile(own), "box", stand_in=True, transmit=True))
    assert made.pattern.script == {"out": ("1", '{"data": 2}')}
    assert parse_create(made.create).options["standin.transmit"] == "default"
    quiet = only(wanted(make.profile(make.component("Source0")), "box", stand_in=True))
    assert "standin.transmit" not in parse_create(quiet.create).options


@pytest.mark.parametrize("text", ["[1", "7", "[]", ""])
def test_bad_scripts_are_told(make, text):
    own = make.component("Source0", properties={"rtkit.stand-in.out": text})
    with pytest.raises(Malformed, match=r"Source0: property rtkit\.stand-in\.out"):
        wanted(make.profile(own), "box", stand_in=True)


def test_service_interfaces_come_from_connectors(make):
    told = {"A0.port.p.provided.My::Type.name": "IOR:00"}
    parts = [make.component(name, ports=(), services=("p",)) for name in ("A0", "B0")]
    wire = make.service("w", "B0.p", "A0.p", told)
    system = wanted(make.profile(*parts, wire), "box", stand_in=True)
    ports = {c.instance: c.ports[0].interfaces[0] for c in system.components}
    assert (ports["A0"].type_name, ports["A0"].instance_name) == ("My::Type", "name")
    assert ports["A0"].polarity is Polarity.PROVIDED
    assert ports["B0"].polarity is Polarity.REQUIRED
    assert system.connectors[0].profile.properties == {"port.port_type": "CorbaPort"}


def test_interfaces_of_a_saved_stand_in_are_read(make):
    port = make.port("p", {"rtkit.interfaces": "Provided My::Type name,Required T2 n2"})
    component = make.component("A0", ports=())
    component = type(component)(
        **{f: getattr(component, f) for f in component.__slots__} | {"service_ports": (port,)}
    )
    made = only(wanted(make.profile(component), "box", stand_in=True))
    assert [i.type_name for i in made.ports[0].interfaces] == ["My::Type", "T2"]
    assert "rtkit.interfaces" not in made.ports[0].properties


def test_types_that_contradict_a_connection_give_way_in_stand_ins(make):
    told = {"port.port_type": "DataInPort", "dataport.data_type": "IDL:RTC/TimedBoolean:1.0"}
    parts = [make.component("Source0"), make.component("Sink0", ports=(make.port("in", told),))]
    profile = make.profile(*parts, make.data("w", "Source0.out", "Sink0.in"))
    port = wanted(profile, "box", stand_in=True).component("Sink0").ports[0]
    assert port.data_type == "IDL:RTC/TimedLong:1.0"
    assert port.properties["rtkit.stated-type"] == "IDL:RTC/TimedBoolean:1.0"
    assert wanted(profile, "box").component("Sink0").ports[0].data_type.endswith("Boolean:1.0")


def test_a_port_with_connections_of_two_types_takes_any(make):
    parts = [
        make.component("Source0", ports=("out", "out2")),
        make.component("Sink0"),
    ]
    wires = [
        make.data("w", "Source0.out", "Sink0.in"),
        make.data("v", "Source0.out2", "Sink0.in", data_type="TimedShort"),
    ]
    system = wanted(make.profile(*parts, *wires), "box", stand_in=True)
    assert system.component("Sink0").ports[0].data_type == "any"


def test_old_identities_are_kept_as_stated(make):
    component = make.component("Sink0", id="RTC:A, B.cat.Sink:1.0")
    made = only(wanted(make.profile(component), "box", stand_in=True))
    assert (made.pattern.type.vendor, made.pattern.type.type_name) == ("A, B", "Sink")
    assert parse_create(made.create).options["rtkit.id"] == "RTC:A, B.cat.Sink:1.0"


@pytest.mark.parametrize(
    ("own", "restart"),
    [
        ({"rtkit.create": "Sink?manager_name=s"}, "always"),
        ({"rtkit.create": "Sink?manager_name=s", "rtkit.restart": "never"}, "never"),
        ({"rtkit.create": "Sink?manager_name=s&rtkit.restart=never"}, "never"),
        ({"rtkit.create": "Sink?manager_name=t"}, None),
        ({"rtkit.create": "Sink"}, None),
    ],
)
def test_restarts_that_are_said_of_a_slave(make, own, restart):
    """They hold for what it holds and says nothing."""
    profile = make.profile(make.component("Sink0", properties=own))
    told = replace(profile, properties=(ExtensionProperty("rtkit.restart.slave.s", "always"),))
    create = parse_create(only(wanted(told, "box")).create)
    assert create.options.get("rtkit.restart") == restart


def test_restarts_of_a_slave_that_make_no_sense(make):
    told = replace(make.profile(), properties=(ExtensionProperty("rtkit.restart.slave.s", "now"),))
    with pytest.raises(Malformed, match=r"rtkit\.restart\.slave\.s: not one of"):
        wanted(told, "box")
