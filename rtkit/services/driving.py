"""Motion of simulated robots: one thread of a process moves all of its robots in a world."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

from rtkit.services.running import Twist
from rtkit.services.world import HomeWorld, RemoteWorld

Row = Sequence[float]
PERIOD_S = 0.05
_LONGEST_S = 0.2
"""Of one move: who was held up for longer has lost the time."""


class Driven(Protocol):
    """Robot, as those see it who move it."""

    body: str

    def wanted(self, seconds: float) -> Twist | None:
        """Return how it is to move next, None where it stands."""

    def moved(self, row: Row, seconds: float) -> None:
        """Take where it is now; nothing where the world has no such body."""

    def lost(self, error: Exception) -> None:
        """Take that the world does not answer."""


class Crew:
    """Robots of this process in one world; moves them together, in one request a period.

    Args:
        world: A world of this process, or the name of a world service.
    """

    def __init__(self, world: HomeWorld | str) -> None:
        self.world: Any = RemoteWorld(world) if isinstance(world, str) else world
        self.robots: tuple[Driven, ...] = ()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="robots", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Move nobody any longer."""
        self._ended.set()
        if self._thread is not threading.current_thread():
            self._thread.join()
        if isinstance(self.world, RemoteWorld):
            self.world.close()

    def _run(self) -> None:
        last = time.monotonic()
        while not self._ended.wait(max(0.0, last + PERIOD_S - time.monotonic())):
            now = time.monotonic()
            last, seconds = now, min(now - last, _LONGEST_S) * self.world.pace
            for _ in range(parts := math.ceil(seconds / _LONGEST_S)):
                advance(self.world, self.robots, seconds / parts)


def advance(world: Any, robots: Sequence[Driven], seconds: float) -> None:
    """Have robots decide, and move their bodies by that for some time [s]."""
    moving: list[tuple[Driven, Twist]] = []
    for robot in robots:
        with _for(robot):
            twist = robot.wanted(seconds)
            moving += [(robot, twist)] if twist is not None else []
    with _for(*(robot for robot, _ in moving)):
        if moving:
            world.set_moves([(robot.body, *twist, seconds) for robot, twist in moving])
            rows = world.get_poses(names=[robot.body for robot, _ in moving])
            for (robot, _), row in zip(moving, rows, strict=True):
                with _for(robot):
                    robot.moved(row, seconds)


@contextmanager
def _for(*robots: Driven) -> Iterator[None]:
    """Report to robots what goes wrong, so that others go on."""
    try:
        yield
    except Exception as error:
        for robot in robots:
            robot.lost(error)


_CREWS: dict[HomeWorld | str, Crew] = {}
_LOCK = threading.Lock()


def enlist(robot: Driven, world: HomeWorld | str) -> Any:
    """Have a robot moved in a world, "" is a plain of the process; return that world."""
    with _LOCK:
        if world not in _CREWS:
            _CREWS[world] = Crew(world or HomeWorld())
        crew = _CREWS[world]
        crew.robots = (*crew.robots, robot)
        return crew.world


def discharge(robot: Driven, world: HomeWorld | str) -> None:
    """Have a robot moved no longer; the thread ends with the last one."""
    with _LOCK:
        crew = _CREWS[world]
        crew.robots = tuple(each for each in crew.robots if each is not robot)
        if not crew.robots:
            _CREWS.pop(world).close()
