"""States and events as a profile tells them, checked before use."""

from __future__ import annotations

from itertools import count

import pytest

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.metrics import ComponentMetrics
from rtkit.deployment.states.events import condition
from rtkit.deployment.states.leading import Leader, SystemTransition
from rtkit.deployment.states.machine import SystemStates, machine_of
from rtkit.deployment.states.states import States
from rtkit.deployment.states.variants import StateDifference, differences_of
from rtkit.deployment.system import WantedSystem
from rtkit.errors import Malformed, Refused
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, PortType
from rtkit.rtc.profiles import ExecutionContextProfile, PortProfile, TypeProfile

SETS = {"Motor0": ["default", "fast"], "Nav0": ["default"], "a.b": []}
TOLD = {
    "rtkit.states": "standby, explore, dock",
    "rtkit.transitions": "standby -start-> explore; explore -tired-> dock; * -stop-> standby;",
    "rtkit.state.standby": "*=inactive",
    "rtkit.state.dock": "Nav0.variant=bug2; Motor0.fast.gain=1; Motor0.active_set=fast",
    "rtkit.event.tired": "Motor0.configuration.default.level < 10",
    "other.property": "x",
}


def machine(**told: str) -> SystemStates:
    changed = {f"rtkit.{key.replace('__', '.')}": text for key, text in told.items()}
    found = machine_of({**TOLD, **changed}, SETS)
    assert found is not None
    return found


def test_a_machine_is_read() -> None:
    made = machine()
    assert made.first == "standby"
    assert made.table == {
        "standby": {"start": "explore"},
        "explore": {"tired": "dock", "stop": "standby"},
        "dock": {"stop": "standby"},
    }
    assert made.wishes["dock"] == (
        StateDifference("Nav0", ".variant", "bug2"),
        StateDifference("Motor0", "fast.gain", "1"),
        StateDifference("Motor0", "active_set", "fast"),
    )
    assert made.wishes["explore"] == ()
    assert str(made.conditions["tired"]) == "Motor0.configuration.default.level < 10"
    assert made.next("explore", "tired") == "dock"
    assert machine_of({"other.property": "x"}, SETS) is None


def test_a_chart_tells_the_same() -> None:
    chart = {"a": {"go": "b"}, "b": {"back": "a"}}
    found = machine_of({"rtkit.state.b": "Nav0=Absent"}, SETS, chart)
    assert found is not None
    assert found.table == chart
    for told, bad in (
        ({"rtkit.states": "a"}, chart),
        ({}, {"a": {}, "a.b": {}}),
        ({}, {}),
    ):
        with pytest.raises(Malformed, match=r"chart|within"):
            machine_of(told, SETS, bad)


@pytest.mark.parametrize(
    ("told", "why"),
    [
        ({"states": ""}, "names no state"),
        ({"states": "a b"}, "not a name: 'a b'"),
        ({"states": "standby, explore, dock, dock"}, "named twice: dock"),
        ({"transitions": "standby explore"}, "not STATE -EVENT-> STATE"),
        ({"transitions": "standby -go-> explor"}, r"no such state: explor \(did you mean explore"),
        ({"transitions": "standby -go-> *"}, r"no such state: \*"),
        ({"transitions": "standby -a-> explore; standby -a-> dock"}, "to explore and to dock"),
        ({"transitions": "standby -a=b-> explore"}, "not a name: 'a=b'"),
        ({"transitions": "standby -tired-> explore"}, "no event leads to dock"),
        ({"state__doc": "Nav0=Absent"}, r"rtkit.state.doc: no such state \(did you mean dock"),
        ({"state__dock": "Nav1=Active"}, r"no such component: Nav1 \(did you mean Nav0"),
        ({"state__dock": "Nav0=Asleep"}, "cannot be 'Asleep'"),
        ({"state__dock": "Nav0"}, "not NAME=VALUE"),
        ({"state__dock": "*.gain=1"}, "of one component"),
        ({"state__dock": "Nav0=Active; Nav0=Absent"}, "wished Active and Absent"),
        ({"state__dock": "*=Inactive"}, "standby and dock wish the same"),
        ({"event__tire": "lost Nav0"}, r"no transition has that event \(did you mean tired"),
        ({"event__tired": "lost Nav0.x"}, "no such component: Nav0.x"),
        ({"event__tired": "Nav0.level"}, "neither lost NAME nor"),
        ({"event__tired": "Nav0 = 1"}, "names no property"),
        ({"event__tired": "Nav0.level < low"}, "not a number: 'low'"),
        (
            {"transitions": "standby -failed-> explore; * -x-> dock", "event__failed": "lost Nav0"},
            "fails",
        ),
    ],
)
def test_what_makes_no_sense_is_told(told: dict[str, str], why: str) -> None:
    with pytest.raises(Malformed, match=why):
        machine(**told)


def test_everything_wrong_is_told_at_once() -> None:
    with pytest.raises(Malformed) as caught:
        machine(state__dock="Nav1=Active", event__tired="lost Nav2")
    assert "Nav1" in str(caught.value)
    assert "Nav2" in str(caught.value)


def test_names_with_dots_are_the_longest_that_fit() -> None:
    assert differences_of("a.b.gain=1", SETS) == (StateDifference("a.b", ".gain", "1"),)


def world(state: LifeCycleState = LifeCycleState.ACTIVE, zombie: str = "") -> Snapshot:
    context = ExecutionContextProfile("0", ExecutionKind.PERIODIC, 1.0, "Motor0", state=state)
    facts = ComponentFacts(
        "Motor0",
        TypeProfile("Motor"),
        "manager",
        (PortProfile("out", PortType.OUT),),
        {"default": {"level": "9.5", "mode": "a b"}},
        "default",
        (context,),
        zombie=zombie,
    )
    return Snapshot("box", "manager", 1, "", components=(facts,))


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("lost Motor0", False),
        ("lost Nav0", True),
        ("Motor0.state = Active", True),
        ("Motor0.state != Active", False),
        ("Motor0.configuration.default.level < 10", True),
        ("Motor0.configuration.default.level<=9.5", True),
        ("Motor0.configuration.default.level > 9.5", False),
        ("Motor0.configuration.default.level = 9.50", True),
        ("Motor0.configuration.default.mode = a b", True),
        ("Motor0.configuration.default.mode < 1", False),
        ("Motor0.nothing != 1", False),
        ("Nav0.state != Active", False),
        ("Motor0.ports.out.count > 3", False),
    ],
)
def test_conditions(text: str, holds: bool) -> None:
    assert condition(text, SETS).holds(world()) is holds


def test_figures_and_zombies() -> None:
    counted = condition("Motor0.ports.out.count > 3", SETS)
    assert counted.needs_metrics
    assert counted.holds(world(), {"Motor0": ComponentMetrics("Motor0", written={"out": 4})})
    assert condition("lost Motor0", SETS).holds(world(zombie="signal 9"))
    assert not condition("Motor0.state = Active", SETS).holds(world(zombie="signal 9"))


LOOP = "standby -on-> explore; explore -off-> standby; * -x-> dock"


class Held(States):
    """The states of a system of which those hold that are named."""

    def __init__(self, machine: SystemStates, *held: str) -> None:
        super().__init__("S", machine, DeploymentGoal(WantedSystem()))
        self.held = held

    def holds(self, state: str, snapshot: Snapshot) -> bool:
        return state in self.held


def led(states: Held, state: str, every_s: float = 1.0) -> Leader:
    """Return who leads a system from a state, as if each step took so long."""
    moments = count()
    made = Leader(states, lambda _: None, lambda _: None, lambda: next(moments) * every_s)
    made.state = state
    return made


def test_a_leader_goes_where_events_lead_and_where_others_led() -> None:
    leader = led(states := Held(machine(), "standby"), "standby")
    assert leader.step(world(), {}) is None
    states.held = ("explore",)
    # Its event holds at once: it is followed in the next look, after the state was seen.
    assert leader.step(world(), {}) == SystemTransition("standby", "by others", "explore")
    assert leader.step(world(), {}) == SystemTransition("explore", "tired", "dock")
    states.held = ("dock",)
    assert leader.step(world(), {}) is None
    states.held = ()
    assert leader.step(world(), {}) is None
    assert leader.state == "dock"


def test_where_an_event_led_by_itself_it_counts_as_that_event() -> None:
    leader = led(Held(machine(), "dock"), "explore")
    assert leader.step(world(), {}) == SystemTransition("explore", "tired", "dock")


def test_states_that_lead_to_one_another_without_end_are_refused() -> None:
    told = {k: v for k, v in TOLD.items() if k != "rtkit.event.tired"}
    found = machine_of(
        {
            **told,
            "rtkit.transitions": LOOP,
            "rtkit.event.on": "lost Nav0",
            "rtkit.event.off": "lost Nav0",
        },
        SETS,
    )
    assert found is not None
    leader = led(Held(found), "standby", 0.1)
    for _ in range(19):
        assert leader.step(world(), {}) is not None
    with pytest.raises(Refused, match="without an end"):
        leader.step(world(), {})
    slow = led(Held(found), "standby", 1.0)
    for _ in range(30):
        assert slow.step(world(), {}) is not None
