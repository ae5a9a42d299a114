"""Takes the values of one connection, on the thread of the process or on that of a reader."""

from __future__ import annotations

import select
import threading
from collections.abc import Callable

from rtkit.link.ends import Octets
from rtkit.link.local.channel import MARK, NONE, NOW, Channel, Full, Packet
from rtkit.link.local.loop import SocketLoop

_AT_ONCE = 64
"""How many packets are taken before others have their turn."""


class Inflow:
    """Receiving side of a connection.

    Args:
        channel: What is received from.
        deliver: Receives each value without a number, one after the other.
        deliver_numbered: Receives each value with one, or loss.
        loop: Notices values while no reader waits for them.
        ended: Is told once, when the other end is gone.
    """

    def __init__(
        self,
        channel: Channel,
        deliver: Callable[[Octets], object],
        deliver_numbered: Callable[[Packet], object],
        loop: SocketLoop,
        ended: Callable[[Inflow], object],
    ) -> None:
        self._channel = channel
        self._deliver = deliver
        self._deliver_numbered = deliver_numbered
        self._loop = loop
        self._ended = ended
        self._lock = threading.Lock()  # held by the one that receives
        self._is_over = self._is_lent = self._is_unwatched = False
        self._turns = self._seen_turns = 0

    def start(self) -> None:
        """Take values from now on."""
        self._loop.add(self._channel.fileno(), self._take_ready, select.EPOLLIN)

    def close(self) -> None:
        """Take nothing more; a reader that waits returns."""
        self._loop.remove(self._channel.fileno())
        self._channel.close()

    # by a reader

    def borrow(self) -> bool:
        """Have the values read by this thread, until `leave`; False when another one reads them."""
        if self._is_over or not self._lock.acquire(blocking=False):
            return False
        self._turns += 1
        if not self._is_lent:
            self._is_lent = True
            self._loop.modify(self._channel.fileno(), 0)
            self._loop.lend(self)
        return True

    def receive(self, timeout_s: float) -> bool:
        """Deliver the next value; False when none comes in time [s], or never."""
        if timeout_s != self._channel.bound_s:
            self._channel.bound(timeout_s)
        return self._take(0)

    def leave(self) -> None:
        """End what `borrow` began."""
        self._lock.release()
        if self._is_unwatched:
            self._is_unwatched = False
            self._loop.lend(self)

    def sip(self) -> None:
        """Deliver what has come already, if a reader has borrowed this and is not there."""
        if self._is_lent and self._lock.acquire(blocking=False):
            try:
                self._take_present()
            finally:
                self.leave()

    # by the thread of the process

    def look(self) -> bool:
        """See `Lent.look`."""
        if self._turns != self._seen_turns:
            self._seen_turns = self._turns
            return True
        self._is_unwatched = True  # a reader that leaves from now on says so
        if not self._lock.acquire(blocking=False):
            return False
        try:
            self._is_unwatched = self._is_lent = False
            self._loop.modify(self._channel.fileno(), select.EPOLLIN)
        finally:
            self._lock.release()
        return False

    def _take_ready(self) -> None:
        if self._lock.acquire(blocking=False):
            try:
                self._take_present()
            finally:
                self._lock.release()

    def _take_present(self) -> None:
        for _ in range(_AT_ONCE):
            if not self._take(NOW):
                return

    def _take(self, flags: int) -> bool:
        """Deliver what comes next; False when nothing does."""
        if self._is_over:
            return False
        try:
            packet = self._channel.receive(flags)
        except BlockingIOError:
            return False
        except (OSError, ValueError):
            packet = None
        if packet is None:
            self._is_over = True
            self.close()
            self._ended(self)
            return False
        kind, number, value = packet
        if number == NONE:
            self._deliver(value)
        elif kind == MARK:
            self._return_mark(number)
        else:
            self._deliver_numbered(packet)
        return True

    def _return_mark(self, number: int) -> None:
        try:
            self._channel.send_notice(MARK, number)
        except (Full, OSError):
            return  # who has sent it is told nothing in time
