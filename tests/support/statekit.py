"""Simulates a robot with states, for tests of the followers of its events."""

from __future__ import annotations

from fake_manager import FakeManager
from worlds import pattern

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action, Result
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.states.machine import machine_of
from rtkit.deployment.states.states import States
from rtkit.deployment.system import WantedComponent, WantedSystem
from rtkit.rtc.enums import PortType, ReturnCode
from rtkit.rtc.pattern import ContextPattern

SYSTEM = "RTSystem:Me:Robot:1.0"
KINDS = ("Eye", "Motor")
TOLD = {
    "states": "standby, explore, degraded",
    "transitions": "standby -start-> explore; explore -motor_lost-> degraded; * -stop-> standby",
    "state.standby": "*=Inactive",
    "state.explore": "Eye0.gain=5",
    "state.degraded": "Motor0=Absent",
    "event.motor_lost": "lost Motor0",
}
FAILING = {
    "transitions": "standby -start-> explore; explore -motor_lost-> degraded;"
    " degraded -failed-> standby; * -stop-> standby",
    "state.degraded": "Motor0=Absent; Eye0.gain=9",
    "state.standby": "*=Inactive; Motor0=Absent",
}
"""What leads on from a transition to `degraded` that fails."""


def make_world() -> FakeManager:
    """Return a world with the types of the robot."""
    return FakeManager(
        pattern(kind, "out", PortType.OUT, sets={"default": {"gain": "1"}}) for kind in KINDS
    )


def robot(**changed: str) -> States:
    """Return the states of the robot, with some told otherwise."""
    told = {**TOLD, **changed}
    machine = machine_of(
        {f"rtkit.{key}": text for key, text in told.items()},
        {f"{kind}0": ["default"] for kind in KINDS},
    )
    assert machine is not None
    return States(SYSTEM, machine, DeploymentGoal(WantedSystem(tuple(map(_component, KINDS)))))


def _component(kind: str) -> WantedComponent:
    return WantedComponent(
        f"RTC:Me:test:{kind}:1.0",
        f"{kind}0",
        f"localhost/{kind}0.rtc",
        f"/localhost/{kind}0.rtc",
        sets={"default": {"gain": "1"}},
        active_set="default",
        contexts=(ContextPattern("0", rate=10.0),),
        create=f"{kind}?instance_name={kind}0&manager_name={kind}",
    )


def gain_refused(action: Action) -> Result | None:
    """Refuse that the gain is set to 9, as a fault of a world."""
    bad = isinstance(action, act.SetParameters) and action.values == {"gain": "9"}
    return Result(ReturnCode.ERROR, "refused", "no luck") if bad else None
