"""Motion of simulated robots: one thread of a process moves all of its robots in a world."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

from rtkit.services.remote_world import RemoteWorld
from rtkit.services.running import Twist

if TYPE_CHECKING:
    from rtkit.services.world import HomeWorld

Row = Sequence[float]
PERIOD_S = 0.05
_SIGN_OF_LIFE_S = 1.0
"""How often those who stand look where they are [s]: a world begun anew is entered anew then."""
_LONGEST_S = 0.2
"""Of one move: who was held up for longer has lost the time."""


class Driven(Protocol):
    """Robot, as those see it who move it."""

    body: str

    def wanted(self, seconds: float) -> Twist | None:
        """Return how it is to move next, None where it stands until somebody has it woken."""

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
        self._ended, self._called = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="robots", daemon=True)
        self._thread.start()

    def wake(self) -> None:
        """Ask the robots how they are to move; while all stand, nobody else does."""
        self._called.set()

    def close(self) -> None:
        """Move nobody any longer."""
        self._ended.set()
        self._called.set()
        if self._thread is not threading.current_thread():
            self._thread.join()
        if isinstance(self.world, RemoteWorld):
            self.world.close()

    def _run(self) -> None:
        last = looked = time.monotonic()
        moving, standing = True, list(self.robots)
        while not self._ended.is_set():
            if moving:
                self._ended.wait(max(0.0, last + PERIOD_S - time.monotonic()))
                self._called.clear()  # before they are asked: whoever calls now is asked once more
                last, before = time.monotonic(), last
                seconds, robots = min(last - before, _LONGEST_S) * self.world.pace, self.robots
                moving = False
                for _ in range(parts := math.ceil(seconds / _LONGEST_S)):
                    standing = advance(self.world, robots, seconds / parts)
                    moving = len(standing) < len(robots)
            else:
                moving = self._called.wait(max(0.0, looked + _SIGN_OF_LIFE_S - time.monotonic()))
                last = time.monotonic()
            if last >= looked + _SIGN_OF_LIFE_S:
                looked = last
                if self.world.pace and standing and not self._ended.is_set():
                    look(self.world, standing)
                    moving = True  # one may have been put elsewhere, or have lost its world


def advance(world: Any, robots: Sequence[Driven], seconds: float) -> list[Driven]:
    """Have robots decide, and move their bodies by that for some time [s]; return who stands."""
    moving: list[tuple[Driven, Twist]] = []
    standing = []
    for robot in robots:
        with _for(robot):
            twist = robot.wanted(seconds)
            if twist is None:
                standing.append(robot)
            else:
                moving.append((robot, twist))
    with _for(*(robot for robot, _ in moving)):
        if moving:
            world.set_moves([(robot.body, *twist, seconds) for robot, twist in moving])
            look(world, [robot for robot, _ in moving], seconds)
    return standing


def look(world: Any, robots: Sequence[Driven], seconds: float = PERIOD_S) -> None:
    """Tell robots where their bodies are after some time [s]."""
    with _for(*robots):
        rows = world.get_poses(names=[robot.body for robot in robots])
        for robot, row in zip(robots, rows, strict=True):
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


def enlist(robot: Driven, world: HomeWorld | str) -> Crew:
    """Have a robot moved in a world, "" is a plain of the process; return those moved there."""
    with _LOCK:
        if world not in _CREWS:
            _CREWS[world] = Crew(world or _plain())
        crew = _CREWS[world]
        crew.robots = (*crew.robots, robot)
        crew.wake()
        return crew


def _plain() -> HomeWorld:
    from rtkit.services.world import HomeWorld  # which takes numpy

    return HomeWorld()


def discharge(robot: Driven, world: HomeWorld | str) -> None:
    """Have a robot moved no longer; the thread ends with the last one."""
    with _LOCK:
        crew = _CREWS[world]
        crew.robots = tuple(each for each in crew.robots if each is not robot)
        if not crew.robots:
            _CREWS.pop(world).close()
