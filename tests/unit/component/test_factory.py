"""Factories, stand-ins, descriptions."""

from __future__ import annotations

import pytest

from rtkit.component import Component, OutPort, Time, TimedLong
from rtkit.component.describe import describe
from rtkit.component.factory import Factories, free_name
from rtkit.component.standin import is_stand_in, stand_in
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, Polarity, PortType
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import DEFINITION, PortInterfaceProfile, PortProfile, TypeProfile


class Counter(Component):
    """Count."""

    vendor, category, version = "acme", "test", "1.0"
    out = OutPort(TimedLong)


class Counter2(Counter):
    type_name, version = "Counter", "2.0"


PATTERN = ComponentPattern(
    TypeProfile("Arm", "maker", "manipulator", "0.9", "An arm", "C++"),
    ports=(
        PortProfile("goal", PortType.IN, {"dataport.data_type": "IDL:Own/Goal:1.0", "x": "y"}),
        PortProfile("count", PortType.OUT, {"dataport.data_type": "RTC::TimedLong"}),
        PortProfile("text", PortType.OUT, {"dataport.data_type": "IDL:RTC/TimedString:1.0"}),
        PortProfile("raw", PortType.OUT, {}),
        PortProfile(
            "service",
            PortType.SERVICE,
            {"port.port_type": "CorbaPort"},
            (PortInterfaceProfile("i", "Arm", Polarity.PROVIDED),),
        ),
    ),
    sets={"default": {"speed": "1"}, "slow": {"speed": "0.1"}, "__widget__": {"speed": "text"}},
    active_set="slow",
    contexts=(
        ContextPattern("a", ExecutionKind.PERIODIC, 20.0),
        ContextPattern("b", ExecutionKind.EVENT_DRIVEN, 0.0),
    ),
)


def scripted(**script):
    return ComponentPattern(
        PATTERN.type, PATTERN.ports, contexts=PATTERN.contexts, script=dict(script)
    )


@pytest.fixture
def factories():
    made = Factories()
    made.register(Counter)
    made.register(Counter2)
    made.register(PATTERN)
    return made


@pytest.mark.parametrize(
    ("text", "version", "language"),
    [
        ("Counter", "2.0", "Python"),
        ("RTC:acme:test:Counter:Python:1.0", "1.0", "Python"),
        ("RTC:::Counter::1.0", "1.0", "Python"),
        ("RTC:::Arm:C++:", "0.9", "C++"),
    ],
)
def test_finding(factories, text, version, language):
    made = factories.make(parse_create(text))
    assert (made.type.version, made.type.language) == (version, language)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("Counted", "component type Counted is not known"),
        (
            "RTC:::Counter::3.0",
            "Counter:Python:1.0, RTC:acme:test:Counter:Python:2.0",
        ),
        ("RTC:::Arm:Python:", "RTC:maker:manipulator:Arm:C++:0.9"),
    ],
)
def test_what_is_not_found_is_told_with_what_is_known(factories, text, told):
    with pytest.raises(NotFound) as caught:
        factories.make(parse_create(text))
    assert told in str(caught.value)


def test_an_empty_factory_knows_none():
    with pytest.raises(NotFound, match=r"component type Arm is not known$"):
        Factories().make(parse_create("Arm"))


def test_names(factories):
    assert factories.make(parse_create("Counter")).instance == "Counter0"
    taken = {"Counter0", "Counter1", "Counter3"}
    assert factories.make(parse_create("Counter"), taken).instance == "Counter2"
    assert factories.make(parse_create("Counter?instance_name=me")).instance == "me"
    assert free_name("A", ()) == "A0"


def test_options_reach_the_component(factories):
    made = factories.make(parse_create("Counter?conf.default.x=1&exec_cxt.periodic.rate=5"))
    made.initialize()
    assert made.configuration.sets["default"] == {"x": "1"}
    assert made.contexts["0"].rate == 5.0


def test_registering_again_replaces_and_unregistering_forgets(factories):
    class Again(Counter):
        """Count anew."""

        type_name = "Counter"

    before = len(factories.types)
    profile = factories.register(Again)
    assert len(factories.types) == before
    assert factories.find("Counter", version="1.0").description == "Count anew."
    factories.unregister(profile)
    assert factories.find("Counter").version == "2.0"
    with pytest.raises(NotFound):
        factories.unregister(profile)
    with pytest.raises(Refused, match="not a component class"):
        factories.register(dict)


def test_a_constructor_that_fails_refuses_with_its_line(factories):
    class Bad(Component):
        def __init__(self, instance, options):
            raise SystemExit("gone")

    factories.register(Bad)
    with pytest.raises(Refused, match=r"Bad0: .*SystemExit: gone \(test_factory.py:\d+ in __init"):
        factories.make(parse_create("Bad"))


def test_a_stand_in_is_what_the_pattern_says(factories):
    made = factories.make(parse_create("Arm?instance_name=Arm7"))
    assert is_stand_in(made)
    assert not is_stand_in(Counter("Counter0"))
    made.initialize()
    told = describe(made)
    assert made.type == PATTERN.type
    assert told.ports == PATTERN.ports
    assert told.sets == PATTERN.sets
    assert told.active_set == "slow"
    assert [(c.id, c.kind, c.rate) for c in told.contexts] == [
        (c.id, c.kind, c.rate) for c in PATTERN.contexts
    ]
    assert told.cause == ""
    assert made.ports["goal"].data_type is bytes
    assert made.ports["count"].data_type is TimedLong


def test_options_of_a_stand_in():
    made = stand_in(
        PATTERN,
        "Arm0",
        {
            "conf.default.speed": "5",
            "configuration.active_config": "default",
            "execution_contexts": "none",
        },
    )
    made.initialize()
    assert made.configuration.sets["default"] == {"speed": "5"}
    assert made.configuration.active_set == "default"
    assert made.contexts == {}
    assert PATTERN.sets["default"] == {"speed": "1"}


def test_a_stand_in_without_sets_has_none():
    made = stand_in(scripted(), "Arm0")
    assert describe(made).sets == {}
    assert describe(made).active_set == ""


def activate(made):
    made.initialize()
    context = made.contexts["a"]
    context.activate_component(made)
    return context


def test_a_silent_stand_in_is_idle_when_active():
    context = activate(stand_in(PATTERN, "Arm0"))
    assert context.is_idle


def test_a_script_is_written_over_and_over():
    made = stand_in(scripted(count=("1", '{"tm": {"sec": 9}, "data": 2}')), "Arm0")
    got = []
    made.ports["count"].attach("c", got.append)
    context = activate(made)
    before = Time.now()
    for _ in range(3):
        context.tick()
    assert [value.data for value in got] == [1, 2, 1]
    assert got[1].tm == Time(9, 0)
    assert got[0].tm.sec >= before.sec
    context.deactivate_component(made)
    context.tick()
    assert len(got) == 3


def test_default_values_are_written_where_no_script_is():
    made = stand_in(scripted(count=("7",)), "Arm0", {"standin.transmit": "default"})
    got = []
    for name in ("count", "text", "raw"):
        made.ports[name].attach("c", got.append)
    activate(made).tick()
    assert [got[0].data, got[1].data, got[2]] == [7, "", b""]
    assert got[1].tm.sec > 0


@pytest.mark.parametrize(
    ("script", "error", "named"),
    [
        ({"count": ("1", '"x"')}, Malformed, "script of port count: TimedLong.data"),
        ({"goal": ("1",)}, NotFound, "no out port: goal"),
        ({"nowhere": ("1",)}, NotFound, "no out port: nowhere"),
        ({"raw": ('"x"',)}, Malformed, "script of port raw"),
    ],
)
def test_a_script_that_is_wrong_makes_nothing(script, error, named):
    with pytest.raises(error, match=named):
        stand_in(scripted(**script), "Arm0")


def test_an_unknown_way_to_transmit_is_refused():
    with pytest.raises(Malformed, match=r"standin\.transmit=often"):
        stand_in(PATTERN, "Arm0", {"standin.transmit": "often"})


def test_description_of_a_component_in_error():
    class Failing(Counter):
        def on_execute(self, context):
            raise ValueError("x")

    failing = Failing("F0")
    failing.initialize()
    failing.contexts["0"].activate_component(failing)
    failing.contexts["0"].tick()
    told = describe(failing)
    assert told.cause.startswith("ValueError: x")
    assert told.contexts[0].state is LifeCycleState.ERROR
    assert told.active_set == "default"


def test_a_stand_in_that_transmits_answers_calls_with_zeros():
    definition = """module Own {
  struct Pose { double x; string frame; };
  interface Arm {
    Pose pose();
    long move(in double x, out Pose reached);
    void halt();
  };
};
"""
    interfaces = (
        PortInterfaceProfile("arm", "Own::Arm", Polarity.PROVIDED),
        PortInterfaceProfile("hand", "Own::Hand", Polarity.PROVIDED),
        PortInterfaceProfile("eye", "Own::Arm", Polarity.REQUIRED),
    )
    profile = PortProfile("service", PortType.SERVICE, {DEFINITION: definition}, interfaces)
    pattern = ComponentPattern(TypeProfile("Arm"), ports=(profile,))
    port = stand_in(pattern, "Arm0", {"standin.transmit": "default"}).ports["service"]
    assert {each.instance_name for each in port.interfaces} == {"arm", "hand", "eye"}
    (served,) = port.served
    methods = served.interface.methods
    pose = served.invoke(methods["pose"], ())
    assert (pose.x, pose.frame) == (0.0, "")
    assert served.invoke(methods["move"], (1.0,)) == (0, pose)
    assert served.invoke(methods["halt"], ()) is None
    for method, result in (("pose", pose), ("move", (0, pose)), ("halt", None)):
        methods[method].encode_result(result)
    assert stand_in(pattern, "Arm0").ports["service"].served == ()
