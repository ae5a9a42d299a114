"""A component that counts what it does, and goes wrong when it is told to."""

from __future__ import annotations

import inspect
import os
import re
import sys
import time
from pathlib import Path
from typing import Any, Protocol

from rtkit.component import (
    Component,
    InPort,
    Manager,
    OutPort,
    Parameter,
    ServicePort,
    Time,
    TimedULongSeq,
)

sys.path.append(str(Path(__file__).resolve().parents[2]))
from campaign.components.misdeeds import MISDEEDS
from campaign.counts import Counts

LIVES = 1 << 32
"""Lives are told apart by milliseconds, of which so many fit into a value."""


class Favour(Protocol):
    """What cells ask of each other."""

    def grant(self, misdeed: str) -> str:
        """Go wrong that way, on behalf of the caller."""


class Cell(Component):
    """Write a number each cycle; count what comes, what is missing and what comes twice."""

    rate = 50.0

    into = InPort(TimedULongSeq)
    out = OutPort(TimedULongSeq)
    asks = ServicePort.required(Favour, timeout_s=1.0)
    asked = ServicePort.provided(Favour, "favour")
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
        kind, _, how = " ".join(order).partition(": ")
        if order[0] == "sleep":
            time.sleep(float(order[1]))
        elif kind == "loop":
            while True:
                pass
        elif kind == "lock":
            re.match("(a+)+$", "a" * 60 + "b")
        elif kind == "service":
            self._ask(how)
        else:
            return MISDEEDS[how or kind]()
        return None

    def _ask(self, how: str) -> None:
        try:
            self.asks.client.grant(how)
        except Exception as error:  # what the other raised
            self.logger.warning("the neighbour failed: %s", type(error).__name__)

    def grant(self, misdeed: str) -> str:
        """Go wrong in a call of a service."""
        return MISDEEDS[misdeed]()  # type: ignore[return-value]  # a wrong result is one of them


def CellInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Cell)
