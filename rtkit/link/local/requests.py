"""Ends of connections between two processes of one host on which one asks and the other answers.

Pull connectors ask for values, service connectors call operations.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from itertools import count

from rtkit.errors import Unreachable
from rtkit.link.ends import CallerEnd, Fetcher, Octets
from rtkit.link.local.channel import LOST, Channel, Full, Packet
from rtkit.link.local.outlet import PATIENCE_S
from rtkit.link.threads import start_thread


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
            return self._exchange(request, until)
        finally:
            self._lock.release()

    def _exchange(self, request: bytes, until: float) -> Packet:
        number = next(self._numbers)
        self._send(request, number, until)
        while True:
            packet = self._receive(until)
            if packet[1] == number:  # another one is too late
                return packet

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
    """Asking end of one pull stream.

    Only one question is open at a time: the answer to one that was given up may be a value, which
    its writer has no more. It is the answer to the next question then.
    """

    def __init__(self, channel: Channel) -> None:
        super().__init__(channel)
        self._is_open = False

    def fetch(self, timeout_s: float) -> Octets | None:
        """See `Fetcher.fetch`."""
        try:
            kind, _, value = self.ask(b"", timeout_s)
        except OSError:
            return None
        return None if kind == LOST else value

    def _exchange(self, request: bytes, until: float) -> Packet:
        is_late = self._is_open
        if not is_late:
            self._send(request, next(self._numbers), until)
            self._is_open = True
        packet = self._receive(until)
        self._is_open = False
        if is_late and packet[0] == LOST:  # there was none at that time
            return self._exchange(request, until)
        return packet


class LocalCaller(CallerEnd):
    """Caller's end of a service connector.

    Calls that are under way at a time each have a connection; those stay for the next ones. One
    whose answer has not come in time is used again where no other is free: what asks a provider
    that hangs takes no more threads of it with each call.

    Args:
        channel: The first connection.
        another: Opens a further one within a time [s].
    """

    def __init__(self, channel: Channel, another: Callable[[float], Channel]) -> None:
        self._another = another
        self._all = [_Requests(channel)]
        self._free = deque(self._all)
        self._is_closed = False

    def call(self, request: bytes, timeout_s: float) -> bytes:
        """See `CallerEnd.call`."""
        until = time.monotonic() + timeout_s
        try:
            requests = self._taken(timeout_s)
            give_back = self._free.appendleft
            try:
                _, _, answer = requests.ask(request, until - time.monotonic())
                give_back = self._free.append
            finally:
                give_back(requests)
        except TimeoutError:
            raise Unreachable(f"no answer within {timeout_s:g} s") from None
        except (OSError, Unreachable):
            here = self._is_closed
            raise Unreachable(
                "the connection is closed" if here else "the provider is gone"
            ) from None
        return bytes(answer)

    def _taken(self, timeout_s: float) -> _Requests:
        """Return a connection that is free, a new one where there is none.

        Raises:
            Unreachable: There can be none.
        """
        with suppress(IndexError):
            return self._free.pop()
        requests = _Requests(self._another(timeout_s))
        self._all.append(requests)
        if self._is_closed:  # meanwhile
            requests.close()
        return requests

    def close(self) -> None:
        """Call no more; threads that wait are told."""
        self._is_closed = True
        for each in list(self._all):
            each.close()


class AnsweringEnd:
    """Answers requests: those that come over one connection one after the other.

    Each connection has a thread here, which may be inside a provider that never comes back:
    nothing waits for it.

    Args:
        reply_to: Returns the reply to a request; None where there is none.
        forget: Called when it is closed.
    """

    def __init__(
        self, reply_to: Callable[[bytes], Octets | None], forget: Callable[[], object]
    ) -> None:
        self._reply_to = reply_to
        self._forget = forget
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
                _, number, value = packet
                _send_back(channel, self._reply_to(bytes(value)), number)
        except (OSError, ValueError):
            pass  # it is closed, here or there
        finally:
            channel.close()
            self._channels.remove(channel)


def _send_back(channel: Channel, value: Octets | None, number: int) -> None:
    """Send a reply, which is lost if nobody takes it in time."""
    until = time.monotonic() + PATIENCE_S
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
