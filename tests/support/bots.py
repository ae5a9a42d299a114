"""Tiny robots for tests of groups; ``python bots.py FIRST LAST zenoh|lines SLOW,SLOW`` serves some.

A robot is where its last target was. Slow ones take 2 s for each answer.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final

import rtkit
from rtkit.link import places

Six = tuple[float, float, float, float, float, float]
SLOW_S = 2.0


class Bot:
    """Robot at a place."""

    type: Final = ("mobilerobot",)
    version: Final = "1.0"
    status: str = "ready"

    def __init__(self, x: float = 0.0, y: float = 0.0, takes_s: float = 0.0) -> None:
        self._at = [x, y, 0.0, 0.0, 0.0, 0.0]
        self._velocity: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self._takes_s = takes_s
        self.times: int = 0
        self.note: str = "none"
        self.behaviors: Final = _Behaviors(self._at, takes_s)

    def get_location(self, frame: str = "world") -> Annotated[Six, rtkit.Unit("m")]:
        time.sleep(self._takes_s)
        x, y, z, a, b, c = self._at
        return x, y, z, a, b, c

    def plug(self, now: bool = True) -> None:
        self.lamp: float = 0.0

    def get_velocity(self) -> Six:
        time.sleep(self._takes_s)
        return self._velocity

    def set_velocity(self, velocity: Six) -> None:
        time.sleep(self._takes_s)
        self._velocity = velocity
        self.times += 1


class _Behaviors:
    def __init__(self, at: list[float], takes_s: float) -> None:
        self._at = at
        self._takes_s = takes_s
        self._state = "idle"

    def get_moveto(self) -> rtkit.Marker | list[rtkit.Marker] | rtkit.Element:
        return rtkit.Element("behavior", {"state": self._state}, (rtkit.Element("target"),))

    def set_moveto(self, target: rtkit.Marker | list[rtkit.Marker] | rtkit.Element) -> None:
        time.sleep(self._takes_s)
        last: Any = target[-1] if isinstance(target, list) else target
        if abs(last.location[0]) > 1000:
            raise rtkit.PropertyError("bad-value", "too far")
        self._at[: len(last.location)] = last.location
        self._state = "done"

    def stop(self, now: bool = True) -> None:
        self._state = "stopped"


@contextmanager
def fleet(bounds: Sequence[int], slow: Sequence[int]) -> Iterator[list[subprocess.Popen[str]]]:
    """Serve robots/rN for all N below the last bound, a process between each two; odd on zenoh."""
    processes = []
    try:
        for at, (first, last) in enumerate(pairwise(bounds)):
            kind = "zenoh" if at % 2 else "lines"
            words = [sys.executable, __file__, str(first), str(last), kind]
            words.append(",".join(map(str, slow)))
            pipe = subprocess.PIPE
            processes.append(subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True))
        for process in processes:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
        yield processes
    finally:
        for process in processes:
            with suppress(BrokenPipeError):
                process.communicate("", timeout=20)
        for left in Path(places.runtime_dir()).glob("robots*"):
            left.unlink()  # of those that were killed


@contextmanager
def in_processes(**groups: str) -> Iterator[dict[str, subprocess.Popen[str]]]:
    """Serve groups, each in a process of its own, with these members."""
    processes = {}
    try:
        for name, robots in groups.items():
            words = [sys.executable, __file__, "group", name, robots]
            pipe = subprocess.PIPE
            processes[name] = subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True)
        for process in processes.values():
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
        yield processes
    finally:
        for process in processes.values():
            process.send_signal(signal.SIGCONT)
            process.communicate("", timeout=20)


def _serve_group(name: str, robots: str) -> None:
    from rtkit.services.group import Group

    with rtkit.serve(Group(robots=robots, deadline=10.0), name, is_on_zenoh=False):
        print("ready", flush=True)
        sys.stdin.read()


def _serve(first: int, last: int, kind: str, slow: set[int]) -> None:
    with ExitStack() as stack:
        for at in range(first, last):
            bot = Bot(float(at), 0.0, SLOW_S if at in slow else 0.0)
            stack.enter_context(rtkit.serve(bot, f"robots/r{at}", is_on_zenoh=kind == "zenoh"))
        print("ready", flush=True)
        sys.stdin.read()


if __name__ == "__main__" and sys.argv[1] == "group":
    _serve_group(*sys.argv[2:])
elif __name__ == "__main__":
    _serve(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], {*map(int, sys.argv[4].split(","))})
