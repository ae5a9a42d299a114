"""Ends of connectors between two processes of one host."""

from __future__ import annotations

import select
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from itertools import count

from rtkit.errors import Unreachable
from rtkit.link.ends import (
    CallerEnd,
    Deliver,
    Fetcher,
    Inlet,
    Octets,
    Outlet,
    Payload,
    Reader,
    joined,
)
from rtkit.link.local.channel import LOST, MARK, MOST_INLINE, NONE, Channel, Full, Packet, size_of
from rtkit.link.local.inflow import Inflow
from rtkit.link.local.loop import SocketLoop
from rtkit.link.threads import start_thread

_PATIENCE_S = 5.0
"""How long a blocking sender waits for a receiver that takes nothing [s]."""
_MOST_QUEUED = 8 << 20
"""How much a sender that does not wait keeps for the socket [bytes]; the oldest are lost first."""


class SentCount:
    """The number of values that a sender has sent, in memory that its receiver reads, too.

    Raises:
        OSError: It cannot be mapped.
        ValueError: It is too small.
    """

    SIZE = 4096

    def __init__(self, descriptor: int) -> None:
        import mmap

        self._value = memoryview(mmap.mmap(descriptor, self.SIZE)).cast("Q")

    @property
    def value(self) -> int:
        """The number."""
        return self._value[0]

    def next(self) -> int:
        """Return the number of the next value, which is sent now."""
        number = self._value[0]
        self._value[0] = number + 1
        return number


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
        self.patience_s = _PATIENCE_S if is_blocking else 0.0
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
        deliver = self._take if sent is None else self._take_numbered
        inflow = Inflow(channel, deliver, self._loop, self._note_end)
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

    def _take(self, packet: Packet) -> None:
        self._deliver(packet.value)

    def _take_numbered(self, packet: Packet) -> None:
        self._count(packet.number)
        if packet.kind == LOST:
            self._count(packet.number + 1)
        else:
            self._next += 1
            self._deliver(packet.value)
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


class _Requests:
    """Sends requests over a connection, one after the other, and waits for each reply."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._lock = threading.Lock()
        self._numbers = count()

    def ask(self, request: bytes, timeout_s: float) -> Packet:
        """Return the reply.

        Raises:
            TimeoutError: There is none in time [s].
            OSError: The other end is gone.
        """
        until = time.monotonic() + timeout_s
        if not self._lock.acquire(timeout=max(timeout_s, 0.0)):
            raise TimeoutError
        try:
            number = next(self._numbers)
            self._send(request, number, until)
            while True:
                packet = self._receive(until)
                if packet.number == number:  # another one is too late
                    return packet
        finally:
            self._lock.release()

    def _send(self, request: bytes, number: int, until: float) -> None:
        while True:
            try:
                self._channel.send(request, number)
            except Full as full:
                if not self._channel.await_room(full, until):
                    raise TimeoutError from None
            else:
                return

    def _receive(self, until: float) -> Packet:
        left_s = until - time.monotonic()
        if left_s <= 0:
            raise TimeoutError
        self._channel.bound(left_s)
        try:
            packet = self._channel.receive()
        except BlockingIOError:
            raise TimeoutError from None
        except ValueError as error:
            raise ConnectionError(str(error)) from error
        if packet is None:
            raise ConnectionError
        return packet

    def close(self) -> None:
        """Ask no more; a thread that waits is told."""
        self._channel.close()


class LocalFetcher(_Requests, Fetcher):
    """Asking end of one pull stream."""

    def fetch(self, timeout_s: float) -> Octets | None:
        """See `Fetcher.fetch`."""
        try:
            packet = self.ask(b"", timeout_s)
        except OSError:
            return None
        return None if packet.kind == LOST else packet.value


class LocalCaller(_Requests, CallerEnd):
    """Caller's end of a service connector."""

    def call(self, request: bytes, timeout_s: float) -> bytes:
        """See `CallerEnd.call`."""
        try:
            return bytes(self.ask(request, timeout_s).value)
        except TimeoutError:
            raise Unreachable(f"no answer within {timeout_s:g} s") from None
        except OSError:
            here = self._channel.is_closed
            raise Unreachable(
                "the connection is closed" if here else "the provider is gone"
            ) from None


class AnsweringEnd:
    """Answers requests, one after the other.

    Each who asks has a thread here, which may be inside a provider that never comes back: nothing
    waits for it.

    Args:
        reply_to: Returns the reply to a request; None where there is none.
        forget: Called when it is closed.
    """

    def __init__(
        self, reply_to: Callable[[bytes], Octets | None], forget: Callable[[], object]
    ) -> None:
        self._reply_to = reply_to
        self._forget = forget
        self._lock = threading.Lock()
        self._channels: list[Channel] = []
        self._is_closed = False

    def connect(self, channel: Channel, key: str) -> bool:
        """Answer what comes over a connection from now on; False when this is closed."""
        self._channels.append(channel)
        if self._is_closed:
            return False
        start_thread(lambda: self._run(channel), f"serve {key}")
        return True

    def close(self) -> None:
        """Answer no more."""
        self._is_closed = True
        self._forget()
        for channel in list(self._channels):
            channel.close()

    def _run(self, channel: Channel) -> None:
        try:
            while (packet := channel.receive()) is not None:
                with self._lock:
                    value = self._reply_to(bytes(packet.value))
                _send_back(channel, value, packet.number)
        except (OSError, ValueError):
            pass  # it is closed, here or there
        finally:
            channel.close()
            self._channels.remove(channel)


def _send_back(channel: Channel, value: Octets | None, number: int) -> None:
    """Send a reply, which is lost if nobody takes it in time."""
    until = time.monotonic() + _PATIENCE_S
    while True:
        try:
            if value is None:
                channel.send_notice(LOST, number)
            else:
                channel.send(value, number)
        except Full as full:
            if not channel.await_room(full, until):
                return
        else:
            return
