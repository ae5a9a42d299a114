"""Bug navigators as behaviours of robots on wheels and on legs."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip("numpy")
from bug.environments import shipped

import rtkit
from rtkit.services import driving
from rtkit.services.legged import LeggedRobot
from rtkit.services.mobilerobot import DifferentialRobot
from rtkit.services.world import HomeWorld
from rtkit.world import Scene


def run(kind: Any, world: str, variant: str, longest_s: float = 600.0) -> Any:
    """Have a robot go to the goal of a world of Bug navigation; return it, and its home."""
    environment = shipped()[world]
    home = HomeWorld(pace=0)
    home._scene = Scene(environment.scene.walls)
    place = (*environment.start, environment.heading)
    robot = kind(world=home, start=place, behaviors=f"{variant}=bug.behavior:{variant}", body="it")
    with robot:
        target = rtkit.Marker(environment.goal, frame="world")
        getattr(robot.behaviors, f"set_{variant}")(target)
        for _ in range(int(longest_s / 0.1)):
            driving.advance(home, [robot._chassis], 0.1)
            if robot._chassis.running.state != "running":
                break
        told = getattr(robot.behaviors, f"get_{variant}")()
        return told, robot.get_location(), home.bodies.get("it").features["collisions"]


@pytest.mark.parametrize("kind", [DifferentialRobot, LeggedRobot])
@pytest.mark.parametrize("variant", ["bug1", "bug2", "distbug"])
def test_the_same_navigator_leads_either_robot_round_a_box(kind: Any, variant: str) -> None:
    told, (x, y, *_), collisions = run(kind, "one-box", variant)
    assert (told.attributes["state"], collisions) == ("done", 0)
    goal = shipped()["one-box"].goal
    assert (x, y) == pytest.approx(goal, abs=0.31)


def test_what_cannot_be_reached_fails_with_the_reason() -> None:
    told, _, collisions = run(DifferentialRobot, "closed", "bug2")
    assert (told.attributes["state"], collisions) == ("failed", 0)
    assert told.find("error").leaf == "the goal is unreachable"


def test_a_variant_that_is_not_there_is_refused_with_those_that_are() -> None:
    with pytest.raises(rtkit.PropertyError, match="no variant bug9; there are alg1, alg2, bug1"):
        DifferentialRobot(behaviors="bug9=bug.behavior:bug9")
