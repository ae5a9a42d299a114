"""Sending end of a stream between two processes of one host."""

from __future__ import annotations

import select
import threading
import time
from collections import deque
from collections.abc import Callable
from itertools import count

from rtkit.link.ends import Outlet, Payload, joined
from rtkit.link.local.channel import LOST, MARK, MOST_INLINE, NONE, Channel, Full, size_of
from rtkit.link.local.loop import SocketLoop
from rtkit.link.local.sent_count import SentCount

PATIENCE_S = 5.0
"""How long a blocking sender waits for a receiver that takes nothing [s]."""
_MOST_QUEUED = 8 << 20
"""How much a sender that does not wait keeps for the socket [bytes]; the oldest are lost first."""


class LocalOutlet(Outlet):
    """Sending end of one stream.

    Args:
        channel: To the receiver.
        loop: Sends what did not fit into the socket, where nothing is to wait.
        is_blocking: Whether it waits instead.
        sent: Counts the values, where they are numbered.
        report: Is told, in a line, why large values cannot be sent.
    """

    def __init__(
        self,
        channel: Channel,
        loop: SocketLoop,
        *,
        is_blocking: bool,
        sent: SentCount | None,
        report: Callable[[str], object],
    ) -> None:
        self.patience_s = PATIENCE_S if is_blocking else 0.0
        self._channel = channel
        self._loop = loop
        self._sent = sent
        self._report = report
        self._lock = threading.Lock()
        self._queue: deque[tuple[bytes | None, int]] = deque()
        self._queued = 0
        self._is_drained = threading.Event()
        self._is_drained.set()
        self._marks = count(1)

    def put(self, value: Payload) -> bool:
        """See `Outlet.put`."""
        number = NONE if self._sent is None else self._sent.next()
        if self._queue and self._queue_behind(value, number):
            return True
        try:
            self._channel.send(value, number)
        except Full as full:
            return self._wait(full, value, number) if self.patience_s else self._late(value, number)
        except OSError as error:
            return self._failed(value, error)
        return True

    def offer(self, value: Payload) -> bool:
        """See `Outlet.offer`."""
        try:
            self._channel.send(value, NONE if self._sent is None else self._sent.value)
        except (Full, OSError):
            return False
        if self._sent is not None:
            self._sent.next()
        return True

    def flush(self, timeout_s: float) -> bool:
        """See `Outlet.flush`."""
        until = time.monotonic() + timeout_s
        if not self._is_drained.wait(timeout_s):
            return False
        mark = next(self._marks)
        try:
            while True:
                try:
                    self._channel.send_notice(MARK, mark)
                    break
                except Full as full:
                    if not self._channel.await_room(full, until):
                        return False
        except OSError:
            return False
        return self._channel.await_mark(mark, until)

    def close(self) -> None:
        """See `Outlet.close`."""
        with self._lock:
            self._queue.clear()
            self._loop.remove(self._channel.fileno())
            self._is_drained.set()
        self._channel.close()

    def _wait(self, full: Full, value: Payload, number: int) -> bool:
        until = time.monotonic() + self.patience_s
        while self._channel.await_room(full, until):
            try:
                self._channel.send(value, number)
            except Full as again:
                full = again
            except OSError as error:
                return self._failed(value, error)
            else:
                return True
        return False

    def _failed(self, value: Payload, error: OSError) -> bool:
        if not isinstance(error, ConnectionError) and size_of(value) > MOST_INLINE:
            why = error.strerror or error
            self._report(f"a value of {size_of(value)} bytes cannot be sent: {why}")
        return False

    # what does not fit, where nothing waits

    def _late(self, value: Payload, number: int) -> bool:
        """Keep a value until it fits; a large one is lost, as memory for it is bounded."""
        with self._lock:
            if self._append(value, number):
                self._is_drained.clear()
                self._loop.add(self._channel.fileno(), self._drain, select.EPOLLOUT)
        return True

    def _queue_behind(self, value: Payload, number: int) -> bool:
        """Keep a value behind others; False when they have been sent meanwhile."""
        with self._lock:
            if not self._queue:
                return False
            self._append(value, number)
            return True

    def _append(self, value: Payload, number: int) -> bool:
        size = size_of(value)
        is_small = size <= MOST_INLINE
        if not is_small and number == NONE:
            return False
        self._queue.append((joined(value) if is_small else None, number))
        self._queued += size * is_small
        while self._queued > _MOST_QUEUED:
            self._queued -= len(self._queue.popleft()[0] or b"")
        return True

    def _drain(self) -> None:
        with self._lock:
            try:
                while self._queue:
                    value, number = self._queue[0]
                    if value is None:
                        self._channel.send_notice(LOST, number)
                    else:
                        self._channel.send(value, number)
                    self._queue.popleft()
                    self._queued -= len(value or b"")
            except Full:
                return
            except OSError:
                self._queue.clear()
            self._queued = 0
            self._loop.remove(self._channel.fileno())
            self._is_drained.set()
