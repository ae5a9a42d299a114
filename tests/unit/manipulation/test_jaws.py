"""The plotting-table manipulator does what the client of any robot asks."""

from __future__ import annotations

import pytest

pytest.importorskip("numpy")
from manipulation.execution import CELL
from manipulation.jaws import Jaws

import rtkit
from rtkit.services import driving


def at(x: float, y: float) -> rtkit.Marker:
    return rtkit.Marker((x * CELL, y * CELL), frame="world")


def go(jaws: Jaws) -> str:
    chassis = jaws._chassis
    for _ in range(400):
        driving.advance(chassis.world, [chassis], 0.05)
        if chassis.running is None or chassis.running.state != "running":
            break
    return str(jaws.behaviors.get_moveto().attributes["state"])


def test_it_carries_a_thing_to_a_marker() -> None:
    with Jaws(pace=0) as jaws:
        gripper, things = jaws.actuators["gripper"], jaws._table.table.things
        name = min(things, key=lambda each: things[each].at)
        assert gripper.grip() == "empty"
        jaws.behaviors.set_moveto(rtkit.Marker(things[name].at, frame="world"))
        assert go(jaws) == "done"
        assert (gripper.grip(), gripper.get_holding()) == ("done", name)
        jaws.behaviors.set_moveto([at(1, 5), at(2, 2)])
        assert go(jaws) == "done"
        assert (gripper.release(), gripper.get_holding()) == ("done", "")
        assert things[name].at == pytest.approx((0.2, 0.2), abs=0.011)
        jaws.behaviors.set_moveto(rtkit.Marker((0.1, 0.0)))  # forward
        assert go(jaws) == "done"
        assert jaws.get_location()[:2] == pytest.approx((0.3, 0.2), abs=0.021)


def test_a_wall_ends_the_way_of_what_it_holds() -> None:
    with Jaws(site="switch", pace=0) as jaws:
        gripper, things = jaws.actuators["gripper"], jaws._table.table.things
        jaws.behaviors.set_moveto(rtkit.Marker(min(b.at for b in things.values()), frame="world"))
        assert (go(jaws), gripper.grip()) == ("done", "done")
        jaws.behaviors.set_moveto([at(3, 2), at(7, 2)])  # a wall stands at (5 2)
        assert go(jaws) == "failed"
        assert jaws.get_location()[0] < 0.45
        assert "something is in the way" in str(jaws.behaviors.get_moveto())
