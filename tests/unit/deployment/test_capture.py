import pytest

from rtkit.deployment import actions as act
from rtkit.deployment.capture import SystemHeading, capture
from rtkit.deployment.creation import creation_plan
from rtkit.deployment.layered_plan import merged
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.wiring import wiring_plan
from rtkit.fast_dataclass import replace
from rtkit.profile.words import property_value
from rtkit.rtc.connector_properties import INTERFACE_TYPE
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import ConnectorProfile, PortRef

DAY = "2025-01-01T00:00:00"


def bring_up(make, world, profile, **how):
    system, _ = make.live(profile, world, **how)
    for plan in (creation_plan, wiring_plan):
        for action, _ in merged(plan(system, LiveIndex(world.snapshot(), system)).steps):
            assert world.perform(action).ok, action


def save(world, **how):
    return capture(world.snapshot(), SystemHeading(DAY), **how)


def test_heading(world):
    heading = SystemHeading(DAY, "Robot", "2", "Us", "Drives")
    made = capture(world.snapshot(), heading)
    assert (made.id, made.abstract, made.version) == ("RTSystem:Us:Robot:2", "Drives", "0.2")
    assert (made.creation_date, made.update_date) == (DAY, DAY)
    assert SystemHeading(DAY).id == "RTSystem:Me:RTSystem:0"


def test_a_pair_is_saved_with_its_origin(make, world):
    bring_up(make, world, make.pair())
    made = save(world)
    sink, source = made.components
    assert (sink.instance_name, sink.path_uri) == ("Sink0", "localhost/Sink0.rtc")
    assert sink.id == "RTC:Me:test:Sink:1.0"
    assert sink.active_configuration_set == "fast"
    assert {s.id: {d.name: d.data for d in s.data} for s in sink.configuration_sets} == {
        "default": {"gain": "2", "mode": "a"},
        "fast": {"gain": "9", "mode": "b"},
    }
    assert [(e.id, e.kind, e.rate) for e in sink.execution_contexts] == [("0", "PERIODIC", 1000.0)]
    assert property_value(sink.properties, "rtkit.create") == (
        "Sink?manager_name=slaveSink0&instance_name=Sink0"
    )
    assert property_value(source.data_ports[0].properties, "port.port_type") == "DataOutPort"
    (wire,) = made.data_port_connectors
    assert (wire.source.port_name, wire.target.port_name) == ("Source0.out", "Sink0.in")
    assert property_value(wire.target.properties, "COMPONENT_PATH_ID") == "localhost/Sink0.rtc"
    assert (wire.data_type, wire.interface_type, wire.dataflow_type, wire.subscription_type) == (
        "IDL:RTC/TimedLong:1.0",
        "corba_cdr",
        "push",
        "new",
    )


def test_the_interface_type_is_saved_by_its_usual_name_too(make, world):
    bring_up(make, world, make.pair())
    ends = (PortRef("Source0", "out"), PortRef("Sink0", "in"))
    world.perform(act.Connect(ConnectorProfile("v", "v", ends, {INTERFACE_TYPE: "zenoh"})))
    wire = next(w for w in save(world).data_port_connectors if w.connector_id == "v")
    assert (wire.connector_id, wire.interface_type) == ("v", "corba_cdr")
    assert property_value(wire.properties, INTERFACE_TYPE) == "zenoh"


def test_only_connected_components_unless_all_are_wanted(make, world):
    bring_up(make, world, make.pair())
    world.perform(act.Create("Sink"))
    assert [c.instance_name for c in save(world).components] == ["Sink0", "Source0"]
    everything = save(world, takes_all=True)
    assert [c.instance_name for c in everything.components] == ["Sink0", "Sink1", "Source0"]


def test_only_some_hosts(make, world):
    world.perform(act.Create("Sink", ("far/Sink0.rtc",)))
    world.perform(act.Create("Sink"))
    for hosts, names in ((["far"], ["Sink0"]), (["localhost"], ["Sink1"]), (["x"], [])):
        saved = save(world, takes_all=True, hosts=hosts)
        assert [c.instance_name for c in saved.components] == names


def test_zombies_are_left_out(make, world):
    bring_up(make, world, make.pair())
    world.kill("slaveSink0")
    assert [c.instance_name for c in save(world, takes_all=True).components] == ["Source0"]
    assert not save(world).components


def test_one_without_a_name_is_saved_below_its_manager(world):
    world.perform(act.Create("Sink"))
    world.update("Sink0", names=())
    (component,) = save(world, takes_all=True).components
    assert component.path_uri == "localhost/manager.mgr/Sink0.rtc"


def test_the_module_of_a_type_is_saved(world, make):
    world.modules["/m/sink.py"] = (make.pattern("Late", "in", PortType.IN),)
    world.perform(act.Load("/m/sink.py", "init"))
    world.perform(act.Create("Late"))
    (component,) = save(world, takes_all=True).components
    assert property_value(component.properties, "rtkit.module") == "/m/sink.py:init"


@pytest.mark.parametrize("told", ["fast", "nan", "0"])
def test_what_is_no_interval_is_saved_as_the_property_that_it_is(make, world, told):
    bring_up(make, world, make.pair())
    ends = (PortRef("Source0", "out"), PortRef("Sink0", "in"))
    odd = ConnectorProfile("v", "v", ends, {"dataport.push_interval": told})
    made = capture(replace(world.snapshot(), connectors=(odd,)), SystemHeading(DAY))
    (wire,) = made.data_port_connectors
    assert wire.push_interval is None
    assert property_value(wire.properties, "dataport.push_interval") == told


def test_references_to_objects_are_not_saved(make, world):
    bring_up(make, world, make.pair())
    told = {"dataport.corba_cdr.inport_ior": "x", "a": "IOR:00", "dataport.push_interval": "0.5"}
    world.perform(
        act.Connect(
            ConnectorProfile("v", "v", (PortRef("Source0", "out"), PortRef("Sink0", "in")), told)
        )
    )
    wire = save(world).data_port_connectors[0]
    assert (wire.connector_id, wire.properties, wire.push_interval) == ("v", (), 0.5)
    assert (wire.interface_type, wire.dataflow_type, wire.subscription_type) == (
        "corba_cdr",
        "push",
        None,
    )


@pytest.mark.parametrize(
    ("told", "active", "sets"),
    [
        ({}, None, []),
        ({"sets": {"default": {}}, "active": "default"}, "default", ["default"]),
        ({"sets": {"a": {"x": "1"}}}, None, ["a"]),
        ({"active": "a"}, "a", []),
        ({"sets": {"a": {}}, "active": "a"}, "a", ["a"]),
    ],
)
def test_what_a_profile_leaves_open_stays_open(make, world, told, active, sets):
    bring_up(make, world, make.profile(make.component("Sink0", **told)), stand_in=True)
    (component,) = save(world, takes_all=True).components
    assert component.active_configuration_set == active
    assert [s.id for s in component.configuration_sets] == sets


def test_stand_ins_are_marked_and_keep_the_words_of_their_profile(make, world):
    told = {"port.port_type": "DataInPort", "dataport.data_type": "IDL:RTC/TimedBoolean:1.0"}
    original = make.profile(
        make.component("Source0", properties={"rtkit.stand-in.out": "[7]"}),
        make.component(
            "Sink0",
            id="RTC:A.cat.Sink:1.0",
            ports=(make.port("in", told),),
            contexts=(("Ec1", "PeriodicExecutionContext", 5.0),),
        ),
        make.component("A0", ports=(), services=("p",)),
        make.component("B0", ports=(), services=("p",)),
        make.data("w", "Source0.out", "Sink0.in"),
        make.service("s", "A0.p", "B0.p", {"A0.port.p.provided.T.n": "IOR:0"}),
    )
    bring_up(make, world, original, stand_in=True)
    saved = save(world)
    by_name = {c.instance_name: c for c in saved.components}
    sink = by_name["Sink0"]
    assert sink.id == "RTC:A.cat.Sink:1.0"
    assert sink.execution_contexts[0].kind == "PeriodicExecutionContext"
    assert property_value(sink.properties, "rtkit.stand-in") == "yes"
    stated = property_value(sink.data_ports[0].properties, "dataport.data_type")
    assert stated == "IDL:RTC/TimedBoolean:1.0"
    assert property_value(by_name["Source0"].properties, "rtkit.stand-in.out") == "[7]"
    interfaces = property_value(by_name["B0"].service_ports[0].properties, "rtkit.interfaces")
    assert interfaces == "Required T n"
    again = make.source_and_sink()
    bring_up(make, again, saved)
    assert save(again) == saved
    first, second = ({c.instance: c for c in w.snapshot().components} for w in (world, again))
    assert second == first


def test_saving_does_not_depend_on_the_order_of_creation(make, world):
    bring_up(make, world, make.pair())
    first = save(world)
    other = make.source_and_sink()
    for action in reversed([a for a in world.performed if isinstance(a, act.Create)]):
        other.perform(action)
    bring_up(make, other, make.pair())
    assert save(other) == first
