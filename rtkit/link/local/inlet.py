"""Receiving end of a stream between two processes of one host."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress

from rtkit.link.ends import Deliver, Inlet, Reader
from rtkit.link.local.channel import LOST, Channel, Packet
from rtkit.link.local.inflow import Inflow
from rtkit.link.local.loop import SocketLoop
from rtkit.link.local.sent_count import SentCount


class LocalInlet(Inlet):
    """Receiving end of one stream, whose sender may come again.

    Args:
        deliver: Receives the values.
        loop: Takes them while no reader does.
        owns_loop: Whether it ends with this.
        forget: Called when it is closed.
    """

    def __init__(
        self,
        deliver: Deliver,
        loop: SocketLoop,
        forget: Callable[[], object],
        *,
        owns_loop: bool,
    ) -> None:
        self._deliver = deliver
        self._loop = loop
        self._owns_loop = owns_loop
        self._forget = forget
        self._inflows: list[Inflow] = []
        self._sent: SentCount | None = None
        self._next = 0
        self._goal: int | None = None
        self._is_closed = False
        self._is_there = threading.Event()
        self.lost = 0

    def connect(self, channel: Channel, sent: SentCount | None) -> bool:
        """Take what a sender sends from now on; False when this is closed."""
        numbered = self._ignore if sent is None else self._take_numbered
        inflow = Inflow(channel, self._deliver, numbered, self._loop, self._note_end)
        self._sent, self._next = sent, 0
        self._inflows.append(inflow)
        inflow.start()
        if self._is_closed:
            inflow.close()
        return not self._is_closed

    def _note_end(self, inflow: Inflow) -> None:
        is_last = self._inflows[-1:] == [inflow]
        with suppress(ValueError):
            self._inflows.remove(inflow)
        if is_last and self._sent is not None:
            self._count(self._sent.value)

    def _ignore(self, packet: Packet) -> None:
        """Ignore a value with a number, of a sender that has not told that it counts."""

    def _take_numbered(self, packet: Packet) -> None:
        kind, number, value = packet
        self._count(number)
        if kind == LOST:
            self._count(number + 1)
        else:
            self._next += 1
            self._deliver(value)
        if self._goal is not None and self._next >= self._goal:
            self._is_there.set()

    def _count(self, number: int) -> None:
        if number > self._next:
            self.lost += number - self._next
        self._next = number

    def settle(self, timeout_s: float) -> bool:
        """See `Inlet.settle`."""
        if self._sent is None or not self._inflows:
            return self._sent is not None
        self._is_there.clear()
        self._goal = self._sent.value
        is_there = self._next >= self._goal or self._is_there.wait(timeout_s)
        self._goal = None
        return is_there

    def close(self) -> None:
        """See `Inlet.close`."""
        self._is_closed = True
        self._forget()
        for inflow in list(self._inflows):
            inflow.close()
        self._inflows.clear()
        if self._owns_loop:
            self._loop.close()

    def borrow(self) -> Reader | None:
        """See `Inlet.borrow`."""
        inflows = self._inflows
        return inflows[0] if len(inflows) == 1 and inflows[0].borrow() else None

    def sip(self) -> None:
        """See `Inlet.sip`."""
        for inflow in list(self._inflows):
            inflow.sip()
