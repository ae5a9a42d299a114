"""The plotting-table manipulator as a robot: the same properties, and the same `behaviors.moveto`.

``rtserve manipulation.jaws:Jaws jaws -a site=doorway``, in the folder of examples.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

from manipulation.orders import Order
from manipulation.sites import site_named
from manipulation.table import Table, table_of
from rtkit.services.chassis import Chassis
from rtkit.services.mobilerobot import MobileRobot
from rtkit.services.running import Twist


class TableWorld:
    """A table as the world of its jaws; lengths are metres from the place (0 0).

    Attributes:
        pace: How many times as fast as real time they move; 0: by hand.
    """

    def __init__(self, table: Table, pace: float = 1.0) -> None:
        self.table = table
        self.pace = pace
        self._lock = threading.Lock()
        self.bodies = SimpleNamespace(set=lambda *_: None)  # the jaws are there already

    def set_moves(self, moves: Sequence[Any]) -> None:
        """Move the jaws, and what they hold."""
        with self._lock:
            for _, *twist, seconds in moves:
                self.table.drive(*twist, seconds)

    def get_poses(self, names: Sequence[str]) -> list[tuple[float, ...]]:
        """Where the jaws are."""
        return [tuple(self.table.pose)] * len(names)

    def order(self, kind: str) -> str:
        """Have the jaws do something at once; return what came of it."""
        with self._lock:
            table = self.table
            table.take(Order(number=table.report.number + 1, kind=kind))
            return table.tick(0.0).outcome


class Gripper:
    """Jaws that open and close."""

    def __init__(self, world: TableWorld) -> None:
        self._world = world

    def get_holding(self) -> str:
        """What is between them; empty for nothing."""
        return self._world.table.held

    def grip(self) -> str:
        """Close: done, or empty where they felt nothing."""
        return self._world.order("grip")

    def release(self) -> str:
        """Open."""
        return self._world.order("release")


class Slide(Chassis):
    """Carries the jaws, and turns them only where a marker tells a heading."""

    dimensions = (0.05, 0.05, 0.1)

    def steer(self, far: float, bearing: float, seconds: float) -> Twist:
        """Return how to go to a point."""
        return (*super().steer(far, bearing, seconds)[:2], 0.0)


class Jaws(MobileRobot):
    """Manipulator over a plotting table, simulated.

    Args:
        site: Which one of sites.json it stands on.
        seed: Where things really lie.
        top_speed: How fast it travels [m/s].
    """

    type = ("manipulator", "mobilerobot")  # type: ignore[assignment,misc]
    chassis_type = Slide

    def __init__(
        self, *, site: str = "switch", seed: int = 1, top_speed: float = 0.2, pace: float = 1.0
    ) -> None:
        self._table = TableWorld(table_of(site_named(site), seed=seed), pace)
        start = tuple(self._table.table.pose)
        super().__init__(world=self._table, body="jaws", start=start, top_speed=top_speed)
        self.actuators = {"gripper": Gripper(self._table)}
        self.sensors = {}
