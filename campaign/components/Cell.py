"""A component that counts what it does, and goes wrong when it is told to."""

from __future__ import annotations

import ctypes
import inspect
import os
import random
import re
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from rtkit.component import Component, InPort, Manager, OutPort, Parameter, Time, TimedULongSeq

sys.path.append(str(Path(__file__).resolve().parents[2]))
from campaign.counts import Counts

LIVES = 1 << 32
"""Lives are told apart by milliseconds, of which so many fit into a value."""


class NoTextError(Exception):
    """An exception that cannot be shown."""

    def __str__(self) -> str:
        raise ValueError("no text")


def fail(error: BaseException) -> NoReturn:
    """Raise something."""
    raise error


def recur() -> None:
    """Call itself for ever."""
    recur()


async def wait() -> None:
    """Do what nobody awaits."""


def change_process() -> None:
    """Change what all components of a process share."""
    os.chdir("/")
    os.umask(0o077)
    random.seed(0)
    sys.setrecursionlimit(5000)
    for stream in (sys.stdout, sys.stderr):
        stream.close()


def in_threads(work: Callable[[], object]) -> None:
    """Have threads do something."""
    for _ in range(20):
        threading.Thread(target=work, daemon=True).start()


MISDEEDS: Mapping[str, Callable[[], object]] = {
    "raise": lambda: fail(RuntimeError("told to")),
    "raise: SystemExit": sys.exit,
    "raise: KeyboardInterrupt": lambda: fail(KeyboardInterrupt()),
    "raise: no text": lambda: fail(NoTextError()),
    "raise: recursion": recur,
    "raise: memory": lambda: bytearray(1 << 60),
    "raise: coroutine": wait,
    "exit": lambda: os._exit(3),
    "exit: abort": os.abort,
    "exit: segfault": lambda: ctypes.string_at(0),
    "exit: thread": lambda: in_threads(lambda: os._exit(4)),
    "side: prints": lambda: [print("x" * 200) for _ in range(2000)],
    "side: threads": lambda: in_threads(lambda: fail(RuntimeError("in a thread"))),
    "side: process": change_process,
}
"""What a cell does when it is told to, by the kind of fault; what is returned is its result."""


class Cell(Component):
    """Write a number each cycle; count what comes, what is missing and what comes twice."""

    rate = 50.0

    into = InPort(TimedULongSeq)
    out = OutPort(TimedULongSeq)
    gain = Parameter(1, doc="Nothing depends on it; it is to be as it was set")

    def on_initialize(self) -> None:
        """Begin a life."""
        state = os.environ["RTKIT_STATE_DIR"]
        self._orders = os.path.join(state, "orders", self.instance)
        self._counts = Counts(os.path.join(state, "counts"))
        self._index = int(self.options["index"])
        self._record = self._counts.cell(self._index)
        self._life = time.monotonic_ns() // 1_000_000 % LIVES
        self._number = 0
        self._last: dict[int, tuple[int, int]] = {}
        self._then_ns = 0
        self._obey("birth")
        self._record.begin()

    def on_activated(self, context: str) -> None:
        """Be slow if told to."""
        self._obey("activation")

    def on_execute(self, context: str) -> Any:
        """Do as told, else what cells do."""
        done = self._obey("work")
        if inspect.iscoroutine(done):
            return done
        for value in self.into.read_all():
            self._check(*value.data)
        self._number += 1
        self.out.write(TimedULongSeq(Time.now(), (self._index, self._life, self._number)))
        now_ns = time.monotonic_ns()
        self._record.execute(now_ns - self._then_ns if self._then_ns else 0)
        self._then_ns = now_ns
        return None

    def _check(self, sender: int, life: int, number: int) -> None:
        last_life, last = self._last.get(sender, (life, number - 1))
        missing = number - last - 1 if life == last_life else 0
        self._record.receive(sender, missing)
        self._last[sender] = (life, number)

    def _obey(self, when: str) -> object:
        path = f"{self._orders}.{when}"
        try:
            with open(path, encoding="utf-8") as file:
                order = file.read().split()
        except FileNotFoundError:
            return None
        os.unlink(path)
        if order[0] == "sleep":
            time.sleep(float(order[1]))
        elif order[0] == "loop":
            while True:
                pass
        elif order[0] == "lock":
            re.match("(a+)+$", "a" * 60 + "b")
        else:
            return MISDEEDS[" ".join(order)]()
        return None


def CellInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Cell)
