"""What is shown of components and managers as properties, and what a SET of one asks for."""

from __future__ import annotations

import pytest

from rtkit.deployment.actions import (
    ActivateSet,
    Attach,
    ChangeState,
    SetContext,
    SetParameters,
    SetRate,
    Tick,
)
from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.metrics import ComponentMetrics
from rtkit.deployment.properties import Shown, of_component, of_manager
from rtkit.property.codes import PropertyError
from rtkit.property.values import Word
from rtkit.rtc.context_settings import SETTINGS
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, PortType, Transition
from rtkit.rtc.profiles import (
    ConnectorProfile,
    ExecutionContextProfile,
    PortProfile,
    PortRef,
    TypeProfile,
)


def facts(state: LifeCycleState = LifeCycleState.INACTIVE) -> ComponentFacts:
    return ComponentFacts(
        "M0",
        TypeProfile("Motor", "me", "test", "1.0"),
        "manager",
        ports=(
            PortProfile("in", PortType.IN, {"dataport.data_type": "IDL:RTC/TimedLong:1.0"}),
            PortProfile("meta", PortType.SERVICE),
        ),
        sets={"default": {"gain": "1.5", "a.b": ""}, "careful": {"gain": "(not a value"}},
        active_set="default",
        contexts=(ExecutionContextProfile("0", ExecutionKind.PERIODIC, 10.0, "M0", state=state),),
        names=("localhost/M0.rtc",),
    )


def shown(*given: object) -> dict[str, Shown]:
    wires = (ConnectorProfile("c", "c", (PortRef("A0", "out"), PortRef("M0", "in"))),)
    return {each.name: each for each in of_component(facts(*given), wires)}  # type: ignore[arg-type]


def test_a_component_is_told_by_its_facts() -> None:
    known = shown()
    values = {name: known[name].value for name in (
        "state", "type", "active_set", "configuration.default.gain",
        "configuration.careful.gain", "configuration.default.a%2Eb", "contexts.0.rate",
        "ports.in.direction", "ports.in.connected", "ports.in.count", "ports.meta_.direction",
    )}  # fmt: skip
    assert values == {
        "state": Word("Inactive"), "type": "Motor", "active_set": Word("default"),
        "configuration.default.gain": "1.5", "configuration.careful.gain": "(not a value",
        "configuration.default.a%2Eb": "", "contexts.0.rate": 10.0,
        "ports.in.direction": Word("in"), "ports.in.connected": (Word("A0.out"),),
        "ports.in.count": -1, "ports.meta_.direction": Word("service"),
    }  # fmt: skip
    metrics = ComponentMetrics("M0", read={"in": 7})
    counted = {each.name: each.value for each in of_component(facts(), (), metrics)}
    assert counted["ports.in.count"] == 7


def test_what_is_set_becomes_an_action() -> None:
    known = shown()

    def asked(name: str, value: object) -> object:
        change = known[name].change
        assert change is not None
        return tuple(change(value))  # type: ignore[arg-type]

    activate = ChangeState("M0", "0", Transition.ACTIVATE)
    assert asked("state", Word("Active")) == (activate,)
    assert asked("state", Word("Inactive")) == ()
    gain = SetParameters("M0", "default", {"gain": "2"})
    assert asked("configuration.default.gain", "2") == (gain, ActivateSet("M0", "default"))
    assert asked("configuration.careful.gain", "2") == (
        SetParameters("M0", "careful", {"gain": "2"}),
    )
    assert asked("active_set", Word("careful")) == (ActivateSet("M0", "careful"),)
    assert asked("contexts.0.rate", 5) == (SetRate("M0", "0", 5.0),)
    for key in SETTINGS:
        assert asked(f"contexts.0.{key}", "7") == (SetContext("M0", "0", {key: "7"}),)
    guests = asked("contexts.0.participants", (Word("A0"), "B"))
    assert guests == (Attach("M0", "0", "A0"), Attach("M0", "0", "B"))
    assert asked("contexts.0.tick", 2) == (Tick("M0", "0"),) * 2
    with pytest.raises(PropertyError, match="cycles are 1 to 1000, not 0"):
        asked("contexts.0.tick", 0)
    with pytest.raises(PropertyError, match="expected one of"):
        asked("active_set", Word("nonsense"))
    for name in ("type", "ports.in.connected", "ports.in.count"):
        assert known[name].change is None
        assert known[name].spec.access == "r"


@pytest.mark.parametrize(
    ("state", "wanted", "transition"),
    [
        (LifeCycleState.ACTIVE, "Inactive", Transition.DEACTIVATE),
        (LifeCycleState.ERROR, "Inactive", Transition.RESET),
        (LifeCycleState.ERROR, "Active", None),
        (LifeCycleState.ACTIVE, "Error", None),
    ],
)
def test_a_state_is_reached_as_the_life_cycle_has_it(
    state: LifeCycleState, wanted: str, transition: Transition | None
) -> None:
    change = shown(state)["state"].change
    assert change is not None
    if transition is None:
        with pytest.raises(PropertyError) as refused:
            change(Word(wanted))
        assert refused.value.code == "conflict"
    else:
        assert change(Word(wanted)) == (ChangeState("M0", "0", transition),)


def test_a_manager_tells_what_it_has() -> None:
    snapshot = Snapshot("box", "m", 7, "0.1", components=(facts(),))
    settings = {"manager.name": "m", "logger.log_level": "INFO"}
    known = {each.name: each.value for each in of_manager(snapshot, settings)}
    assert known["components"] == (Word("M0"),)
    assert known["pid"] == 7
    assert known["settings.logger.log_level"] == "INFO"
