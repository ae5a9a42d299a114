"""The base class: declarations, options, birth and death."""

from __future__ import annotations

import inspect
import logging
import re
from typing import Protocol

import pytest

from rtkit import component
from rtkit import component as rt
from rtkit.component import (
    Component,
    FsmComponent,
    InPort,
    OutPort,
    Parameter,
    Polarity,
    PortInterfaceProfile,
    ServicePort,
    TimedDouble,
    TimedLong,
    TimedVelocity2D,
)
from rtkit.component.composite import PeriodicECSharedComposite
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, ReturnCode
from rtkit.rtc.profiles import TypeProfile


class Controller(Component):
    """Drive towards an obstacle
    and stop in front of it.

    More about it.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 100.0
    distance = InPort(TimedDouble)
    velocity = OutPort(TimedVelocity2D)
    in_ = InPort(TimedLong)
    named = OutPort(TimedLong, name="Other")
    service = ServicePort("s", (PortInterfaceProfile("i", "T", Polarity.PROVIDED),))
    gain = Parameter(1.0)


class Derived(Controller):
    type_name = "Special"
    extra = OutPort(TimedLong)
    distance = None


def test_identity():
    assert Controller("C0").type == TypeProfile(
        "Controller",
        "rtkit",
        "example",
        "1.0",
        "Drive towards an obstacle and stop in front of it.",
        "Python",
    )
    assert Derived("D0").type == TypeProfile("Special", "rtkit", "example", "1.0", "", "Python")


def test_each_instance_has_its_own_ports():
    one, other = Controller("C0"), Controller("C1")
    assert list(one.ports) == ["distance", "velocity", "in", "Other", "s"]
    assert one.distance is one.ports["distance"]
    assert one.distance is not other.distance
    assert one.distance is not Controller.distance
    assert one.service.interfaces[0].type_name == "T"


def test_declarations_are_inherited_and_may_be_taken_away():
    derived = Derived("D0")
    assert list(derived.ports) == ["velocity", "in", "Other", "s", "extra"]
    assert derived.gain == 1.0
    assert "extra" not in Controller("C0").ports


def test_ports_added_later():
    class Dynamic(Component):
        def on_initialize(self):
            for index in range(2):
                self.add_in_port(f"in{index}", TimedLong)
            self.add_out_port("out", TimedLong, {"description": "Why"})
            self.add_service_port("service")

    dynamic = Dynamic("D0")
    dynamic.initialize()
    assert list(dynamic.ports) == ["in0", "in1", "out", "service"]
    assert dynamic.ports["out"].properties["description"] == "Why"
    with pytest.raises(Refused, match="port out exists already"):
        dynamic.add_in_port("out", TimedLong)
    with pytest.raises(Refused, match="needs a name"):
        dynamic.add_in_port("", TimedLong)


@pytest.mark.parametrize("name", ["", "a/b", "a:b", " a", "a\nb"])
def test_instance_names_are_checked(name):
    with pytest.raises(Malformed):
        Controller(name)


def test_initial_configuration():
    options = {
        "conf.default.gain": "2",
        "conf.default.more": "x",
        "conf.fast.gain": "9",
        "conf.broken": "1",
    }
    made = Controller("C0", options)
    assert made.gain == 2.0
    assert made.configuration.sets == {
        "default": {"gain": "2", "more": "x"},
        "fast": {"gain": "9"},
        "__type__": {"gain": "double"},
    }
    active = Controller("C1", {**options, "configuration.active_config": "fast"})
    assert active.gain == 9.0
    assert active.configuration.active_set == "fast"
    with pytest.raises(NotFound, match="slow"):
        Controller("C2", {"configuration.active_config": "slow"})


class Bounded(Component):
    gain = Parameter(0.5, constraint="0<=x<=1")


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"conf.default.gain": "2"}, "conf.default: gain cannot be '2': it is to be 0<=x<=1"),
        ({"conf.other.gain": "x"}, "conf.other: gain cannot be 'x': it is no number"),
        (
            {"conf.default.free": "3", "conf.__constraints__.free": "(1,2)"},
            r"conf.default: free cannot be '3': it is to be \(1,2\)",
        ),
        (
            {"conf.default.free": "3", "conf.__type__.free": "bool"},
            "conf.default: free cannot be '3': it is no truth value",
        ),
    ],
)
def test_options_that_do_not_fit_keep_a_component_from_being_made(options, why):
    with pytest.raises(Malformed, match=f"^B0: {why}$"):
        Bounded("B0", options)


def test_options_that_fit_are_taken():
    made = Bounded("B0", {"conf.default.gain": "1", "conf.default.free": "3"})
    assert made.gain == 1.0
    assert made.configuration.sets["default"] == {"gain": "1", "free": "3"}


def test_port_defaults_from_options():
    made = Controller(
        "C0",
        {
            "dataport.inport.buffer.length": "20",
            "port.inport.distance.dataport.fan_in": "1",
            "port.outport.dataport.fan_out": "3",
            "port.note": "x",
        },
    )
    distance, into, velocity = made.distance, made.in_, made.velocity
    assert distance.properties["dataport.inport.buffer.length"] == "20"
    assert distance.properties["dataport.fan_in"] == "1"
    assert not any("fan_in" in key for key in into.properties)
    assert velocity.properties["dataport.fan_out"] == "3"
    assert "dataport.fan_out" not in into.properties
    assert made.service.properties["port.note"] == "x"
    assert "dataport.inport.buffer.length" not in made.service.properties


@pytest.mark.parametrize(
    ("options", "contexts"),
    [
        ({}, {"0": 100.0}),
        ({"execution_contexts": "none"}, {}),
        ({"execution_contexts": "None"}, {}),
        ({"exec_cxt.periodic.rate": "50"}, {"0": 50.0}),
        ({"exec_cxt.periodic.type": "PeriodicExecutionContext"}, {"0": 100.0}),
        ({"execution_contexts": "PeriodicExecutionContext"}, {"0": 100.0}),
        (
            {
                "execution_contexts": "PeriodicExecutionContext(fast), Periodic(slow)",
                "ec.Periodic.rate": "10",
                "ec.fast.rate": "500",
                "exec_cxt.periodic.rate": "7",
            },
            {"fast": 500.0, "slow": 10.0},
        ),
        ({"execution_contexts": "periodic,Periodic"}, {"0": 100.0, "1": 100.0}),
    ],
)
def test_execution_contexts(options, contexts):
    made = Controller("C0", options)
    made.initialize()
    assert {id: context.rate for id, context in made.contexts.items()} == contexts
    assert made.participations == tuple(made.contexts.values())
    for context in made.contexts.values():
        assert context.is_running
        assert context.kind is ExecutionKind.PERIODIC
        assert context.state_of(made) is LifeCycleState.INACTIVE


@pytest.mark.parametrize(
    ("options", "error", "named"),
    [
        ({"execution_contexts": "MultilayerCompositeEC"}, Refused, "known: Periodic"),
        ({"exec_cxt.periodic.type": "Sometimes"}, Refused, "Sometimes"),
        ({"execution_contexts": "Periodic(a),Periodic(a)"}, Refused, "a is named twice"),
        ({"execution_contexts": "Periodic(a"}, Malformed, r"Periodic\(a"),
        ({"exec_cxt.periodic.rate": "0"}, Malformed, "exec_cxt.periodic.rate"),
        ({"exec_cxt.periodic.rate": "fast"}, Malformed, "exec_cxt.periodic.rate"),
        ({"execution_contexts": "Periodic", "ec.Periodic.rate": "nan"}, Malformed, "ec.Periodic"),
    ],
)
def test_execution_contexts_that_are_refused_initialise_nothing(options, error, named):
    called = []

    class Watched(Controller):
        def on_initialize(self):
            called.append(True)

    made = Watched("C0", options)
    with pytest.raises(error, match=named):
        made.initialize()
    assert not called
    assert not made.is_alive


def test_birth_and_death_in_order():
    calls = []

    class Living(Component):
        def on_initialize(self):
            calls.append("initialize")

        def on_startup(self, context):
            calls.append(f"startup {context}")

        def on_deactivated(self, context):
            calls.append(f"deactivated {context}")

        def on_shutdown(self, context):
            calls.append(f"shutdown {context}")

        def on_finalize(self):
            calls.append("finalize")

    living = Living("L0")
    living.finalize()
    assert calls == []
    living.initialize()
    with pytest.raises(Refused, match="already"):
        living.initialize()
    living.contexts["0"].activate_component(living)
    living.finalize()
    assert calls == ["initialize", "startup 0", "deactivated 0", "shutdown 0", "finalize"]
    assert not living.is_alive
    assert living.participations == ()


def test_the_end_leaves_contexts_of_others():
    one, other = Controller("C0"), Controller("C1")
    one.initialize()
    other.initialize()
    foreign = one.contexts["0"]
    foreign.add_component(other)
    assert other.context_rate("0") == 100.0
    foreign.activate_component(other)
    other.finalize()
    assert foreign.participants == (one,)
    assert foreign.is_running
    with pytest.raises(NotFound):
        other.context_rate("0")


def test_the_end_of_an_owner_lets_its_participants_go():
    one, other = Controller("C0"), Controller("C1")
    one.initialize()
    other.initialize()
    shared = one.contexts["0"]
    shared.add_component(other)
    shared.activate_component(other)
    one.finalize()
    assert other.participations == (other.contexts["0"],)
    assert shared.participants == ()
    assert other.is_alive


def test_a_return_code_refuses_initialisation():
    class Unwilling(Component):
        def on_initialize(self):
            return ReturnCode.OUT_OF_RESOURCES

    with pytest.raises(Refused, match="U0: on_initialize failed: returned OUT_OF_RESOURCES"):
        Unwilling("U0").initialize()


def test_reports_go_to_the_log_of_the_instance(caplog):
    class Sulking(Component):
        def on_finalize(self):
            raise ValueError("no")

    sulking = Sulking("S0")
    sulking.initialize()
    with caplog.at_level(logging.WARNING):
        sulking.finalize()
    (record,) = caplog.records
    assert record.name == "S0"
    assert record.getMessage().startswith("on_finalize failed: ValueError: no (test_base.py:")


@pytest.mark.parametrize("name", ["ports", "type", "logger", "on_execute", "rate", "initialize"])
@pytest.mark.parametrize("kind", [lambda: OutPort(TimedLong), lambda: Parameter(1)])
def test_no_port_or_parameter_hides_what_every_component_has(name, kind):
    with pytest.raises(Refused) as caught:
        type("Robot", (Component,), {name: kind()})
    assert re.fullmatch(
        rf"test_base\.py:\d+: (port|parameter) {name} of Robot collides with"
        rf" (Component|Callbacks)\.{name}, which rtkit itself uses: write {name}_ = …,"
        rf" the name for others stays {name}",
        str(caught.value),
    )
    made = type("Robot", (Component,), {f"{name}_": OutPort(TimedLong)})("r")
    assert list(made.ports) == [name]


def refused(define):
    with pytest.raises(Refused) as caught:
        define()
    return re.sub(r":\d+:", ":N:", str(caught.value))


def here(function, text):
    """Return the line of this file, within a function, that has this text."""
    lines = inspect.getsource(function).splitlines()
    offset = next(number for number, line in enumerate(lines) if text in line)
    return function.__code__.co_firstlineno + offset


class Leaving(Protocol):
    def leave(self) -> None: ...


def test_a_method_that_hides_one_of_every_component_is_refused_with_its_line():
    def define():
        class Robot(Component):
            speed = Parameter(1)

            def leave(self): ...

    with pytest.raises(Refused) as caught:
        define()
    assert str(caught.value) == (
        f"test_base.py:{here(define, 'def leave')}: method leave of Robot collides with"
        " Component.leave, which rtkit itself uses: give it another name"
    )


def test_the_line_of_a_declaration_is_told():
    def define():
        class Robot(Component):
            """It has a docstring."""

            speed = Parameter(1)
            ports = Parameter(2)

    with pytest.raises(Refused, match=rf"^test_base.py:{here(define, 'ports =')}: parameter ports"):
        define()


def test_attributes_private_helpers_properties_and_mixins_are_looked_at():
    class Mixin:
        def finalize(self): ...

    kinds = [{"logger": logging.getLogger("x")}, {"_log": print}, {"report": print}, {"type": "x"}]
    kinds += [{"rate": property(lambda self: 1.0)}, {"_declared": 3}]
    for each in kinds:
        assert " of Robot collides with " in refused(lambda e=each: type("Robot", (Component,), e))
    text = refused(lambda: type("Robot", (Mixin, Component), {}))
    assert "method finalize of Robot collides with Component.finalize" in text


def test_an_operation_of_its_own_that_the_base_class_would_answer_is_refused():
    text = refused(lambda: type("R", (Component,), {"way": ServicePort.provided(Leaving)}))
    assert text == (
        "test_base.py:N: operation leave, of port way of R collides with Component.leave, which"
        " rtkit itself uses: implementation=… names an object of its own that does it"
    )
    apart = ServicePort.provided(Leaving, implementation=type("X", (), {"leave": print}))
    type("R", (Component,), {"way": apart})("r0")


def test_callbacks_and_settings_are_overridden_and_parameters_declared_anew():
    class Robot(FsmComponent):
        vendor, rate, states, events = "me", 5.0, {"A": {}}, {}

        def on_execute(self, context): ...
        def on_entry(self, state): ...
        def activate(self): ...

    class Faster(Robot):
        vendor = "you"

    class Plain(Component):
        def state(self): ...

    text = refused(lambda: type("R", (FsmComponent,), {"state": Parameter(1)}))
    assert "parameter state of R collides with FsmComponent.state" in text

    type("Whole", (PeriodicECSharedComposite,), {"members": Parameter("a")})
    assert Faster("f0").type.vendor == "you"


def test_what_instances_keep_is_listed():
    assert set(vars(Component("x"))) == set(Component.own_attributes)
    fsm = type("Fsm", (FsmComponent,), {"states": {"A": {}}})
    assert set(vars(fsm("x"))) == set(fsm.own_attributes)


def test_names_can_be_found_by_looking():
    assert {"Component", "InPort", "OutPort", "Parameter", "TimedLong"} <= set(dir(component))


def test_dir_shows_what_authors_use() -> None:
    """What is left out of a list is still there for who names it."""
    names = dir(rt)
    assert {"Component", "InPort", "Parameter", "TimedLong", "takes"} <= set(names)
    assert not [name for name in names if name.startswith("_") or not hasattr(rt, name)]
    assert rt.RangeData

    class Plain(rt.Component):
        gain = rt.Parameter(1.0)

    own = set(dir(Plain("P0")))
    assert {"gain", "on_execute", "logger", "add_in_port"} <= own
    assert not {"keep_failure", "initialize", "stir"} & own
