"""A connection of a command to a manager of its host, over which it sends requests."""

from __future__ import annotations

import _socket
import os
from collections.abc import Callable
from itertools import count
from threading import Condition, Lock
from time import monotonic

from rtkit.errors import Malformed, Unreachable
from rtkit.link import unix
from rtkit.link.deadline import deadline_to_bytes
from rtkit.link.requests.frames import GREETING, reply_of, request_frame, take_frame
from rtkit.property.exchange import Reply

_PIECE = 1 << 16
GONE = "nobody answers for it"


class ConnectionEnded(Exception):
    """The manager has gone before it took a request."""


class RequestConnection:
    """Sends requests of any thread, one after the other; whoever waits for a reply receives it.

    A thread that receives the replies of others, too, hands them over; there is none that only
    receives.

    Args:
        end: Connected, and greeted.
    """

    def __init__(self, end: _socket.socket) -> None:
        self._in = end
        # A time-out belongs to the object, not to the connection.
        self._out = _socket.socket(fileno=os.dup(end.fileno()))
        self._numbers = count(1)
        self._sending = Lock()
        self._changed = Condition()
        self._expected: set[int] = set()
        self._arrived: dict[int, Reply] = {}
        self._received = bytearray()
        self._is_receiving = False
        self._why = ""
        self._is_broken = False

    @property
    def has_ended(self) -> bool:
        """Return whether the manager has hung up; replies may be left to receive."""
        if self._why or self._is_broken:
            return True
        with self._sending:
            try:
                self._out.settimeout(0.0)
                return not self._out.recv(1, _socket.MSG_PEEK)
            except BlockingIOError:
                return False
            except OSError:
                return True

    def send(self, name: str, payload: str | None, timeout_s: float) -> Callable[[], Reply]:
        """Send a request; return what awaits its reply.

        Raises:
            ConnectionEnded: The manager had gone: it has not taken it.
            Unreachable: It takes nothing in time [s]; or it has gone, when the reply is awaited.
        """
        until = monotonic() + timeout_s
        number = next(self._numbers)
        frame = request_frame(number, name, payload, deadline_to_bytes(timeout_s))
        if not self._sending.acquire(timeout=timeout_s):
            raise _late(timeout_s)
        self._expected.add(number)
        try:
            self._out.settimeout(max(until - monotonic(), 0.001))
            self._out.sendall(frame, _socket.MSG_NOSIGNAL)
        except TimeoutError:
            self._end()  # half of a request may be there
            raise _late(timeout_s) from None
        except OSError as error:
            self._is_broken = True  # which replies that nobody awaits hide from who looks
            self._expected.discard(number)
            raise ConnectionEnded from error
        finally:
            self._sending.release()
        return lambda: self._await(number, until, timeout_s)

    def _await(self, number: int, until: float, timeout_s: float) -> Reply:
        try:
            while True:
                with self._changed:
                    while self._is_receiving and not self._is_settled(number):
                        if not self._changed.wait(until - monotonic()):
                            raise _late(timeout_s)
                    if number in self._arrived:
                        return self._arrived.pop(number)
                    if self._why:
                        raise Unreachable(self._why)
                    self._is_receiving = True
                try:
                    self._receive(until, timeout_s)
                finally:
                    with self._changed:
                        self._is_receiving = False
                        self._changed.notify_all()
        finally:
            self._expected.discard(number)

    def _is_settled(self, number: int) -> bool:
        return number in self._arrived or bool(self._why)

    def _receive(self, until: float, timeout_s: float) -> None:
        """Receive what comes next, for whom it may be."""
        left_s = until - monotonic()
        if left_s <= 0:
            raise _late(timeout_s)
        try:
            self._in.settimeout(left_s)
            data = self._in.recv(_PIECE)
        except TimeoutError:
            raise _late(timeout_s) from None
        except OSError:
            data = b""
        if not data:
            self._why = self._why or GONE
            return
        self._received += data
        try:
            while (frame := take_frame(self._received)) is not None:
                number, text, kind = reply_of(frame)
                if number in self._expected:
                    self._arrived[number] = Reply(text, kind)
        except Malformed as error:
            self._why = f"what it answers cannot be read: {error}"

    def _end(self) -> None:
        self._why = self._why or "the connection is closed"
        try:
            self._in.shutdown(_socket.SHUT_RDWR)  # so that threads that wait are told
        except OSError:
            return  # the manager has hung up

    def close(self) -> None:
        """Send no more; threads that wait are told."""
        self._end()
        self._in.close()
        self._out.close()


def connect(path: str, timeout_s: float) -> RequestConnection:
    """Connect to a manager at its socket for requests.

    Raises:
        OSError: Nobody listens there; a TimeoutError if the manager does not answer in time [s].
        Malformed: It does not speak this.
    """
    until = monotonic() + timeout_s
    end = unix.connect_to_manager(path, timeout_s)
    try:
        greeting = b""
        while len(greeting) < len(GREETING):
            end.settimeout(max(until - monotonic(), 0.001))
            data = end.recv(len(GREETING) - len(greeting))
            if not data:
                raise ConnectionResetError
            greeting += data
        if greeting != GREETING:
            raise Malformed(f"no manager of this version: {greeting!r}")
    except BaseException:
        end.close()
        raise
    return RequestConnection(end)


def _late(timeout_s: float) -> Unreachable:
    return Unreachable(f"no answer within {timeout_s:g} s")
