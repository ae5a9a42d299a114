"""A system led on command and by its events, in a simulated world."""

from __future__ import annotations

import pytest
import statekit
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.deployment.applying import Applier
from rtkit.deployment.states.leading import Leader, SystemTransition
from rtkit.deployment.states.states import States
from rtkit.errors import Refused


class Robot:
    """A robot in a world, and who leads it."""

    def __init__(self, states: States, world: FakeManager | None = None) -> None:
        self.world = world or statekit.make_world()
        self.states = states
        self.failed: list[str] = []
        self.leader = Leader(states, self._reach, self.failed.append, lambda: 0.0)

    def _reach(self, passage: SystemTransition) -> None:
        tree, goal = fake_tree(self.world), self.states.goal(passage.state)
        before = tree.snapshot()
        Applier(tree, goal, lambda _: None, lambda _: None).run(goal.plan(before), before)

    def step(self) -> SystemTransition | None:
        return self.leader.step(self.world.snapshot(), {})

    @property
    def state(self) -> str:
        return self.states.now(self.world.snapshot())


def test_it_begins_in_the_first_state_or_where_it_is() -> None:
    robot = Robot(statekit.robot())
    assert robot.leader.begin(robot.world.snapshot()) == ("", "at first", "standby")
    assert robot.state == "standby"
    again = Robot(robot.states, robot.world)
    performed = len(robot.world.performed)
    assert again.leader.begin(robot.world.snapshot()) == ("", "is so", "standby")
    assert len(robot.world.performed) == performed


def test_events_and_others_lead_it() -> None:
    robot = Robot(statekit.robot())
    robot.leader.begin(robot.world.snapshot())
    assert robot.step() is None
    other = Robot(robot.states, robot.world)
    other.leader.lead(SystemTransition("standby", "start", "explore"))
    assert robot.step() == ("standby", "by others", "explore")
    robot.world.kill("Motor")
    assert robot.step() == ("explore", "motor_lost", "degraded")
    assert robot.state == "degraded"
    assert robot.step() is None


def test_what_fails_leads_on_by_failed_or_is_raised() -> None:
    robot = Robot(statekit.robot(**statekit.FAILING))
    robot.leader.lead(SystemTransition("", "goto", "explore"))
    robot.world.fault = statekit.gain_refused
    robot.world.kill("Motor")
    assert robot.step() == ("degraded", "failed", "standby")
    assert robot.failed[0].startswith("explore -motor_lost-> degraded: ")
    assert "no luck" in robot.failed[0]
    assert robot.state == "standby"
    told = {"state.degraded": "Motor0=Absent; Eye0.gain=9"}
    robot = Robot(statekit.robot(**told))
    robot.leader.lead(SystemTransition("", "goto", "explore"))
    robot.world.fault = statekit.gain_refused
    robot.world.kill("Motor")
    with pytest.raises(Refused, match=r"^explore -motor_lost-> degraded: .*no luck"):
        robot.step()
    assert robot.failed == []
