"""Client of the line protocol: asks and listens over a unix socket or TCP."""

from __future__ import annotations

import select
import socket
import struct
from time import monotonic

from rtkit.closing import Closing
from rtkit.errors import Unreachable
from rtkit.link import unix
from rtkit.property.line import Replies, write_request
from rtkit.property.messages import DONE, Answer, Payload, PropertyEvent
from rtkit.wires.property_client import Inbox, bound_in

_PIECE = 1 << 16
_FEW = 1 << 12
"""Bytes that are enough for most: a larger buffer costs time to make."""
_SHORT = 256
_MOST_KNOWN = 4096
"""Targets of which a client remembers the request, and how long they may be."""
_MOST_DRAINED = 1 << 22


class LineClient(Closing):
    """One connection. Requests are answered one after the other; events come in between.

    Args:
        end: A connected socket.
        timeout_s: Bound on each request [s].
    """

    def __init__(self, end: socket.socket, timeout_s: float) -> None:
        self._end = end
        bound = struct.pack("@ll", int(timeout_s), int(timeout_s % 1 * 1e6) or 1)
        end.setblocking(True)
        for direction in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            end.setsockopt(socket.SOL_SOCKET, direction, bound)
        self._timeout_s = timeout_s
        self._replies = Replies()
        self._inbox = Inbox()
        self._gets: dict[str, bytes] = {}
        self._given_up = 0

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
        """See `PropertyClient.ask`."""
        bound_s = bound_in(target, self._timeout_s)
        if payload is None:
            request = self._gets.get(target) or self._get(target)
        else:
            request = write_request(target, payload)
        self._send(request)
        if self._replies.is_idle and not self._given_up and bound_s == self._timeout_s:
            quick = self._quick()
            if quick is not None:
                return quick
        deadline = monotonic() + bound_s
        while True:
            received = self._receive(deadline)
            if received is None:
                self._given_up += 1
                raise Unreachable(f"no answer within {bound_s:g} s")
            if isinstance(received, PropertyEvent):
                self._inbox.put(received)
            elif self._given_up:
                self._given_up -= 1  # replies come in the order of requests: an earlier one's
            else:
                return received[1]

    def _get(self, target: str) -> bytes:
        """Return the request that gets a target, and remember it."""
        request = write_request(target, None)
        if len(target) < _SHORT and len(self._gets) < _MOST_KNOWN:
            self._gets[target] = request
        return request

    def event(self, timeout_s: float | None = None) -> PropertyEvent | None:
        """See `PropertyClient.event`."""
        self._drain()
        known = self._inbox.take()
        if known is not None:
            return known
        deadline = None if timeout_s is None else monotonic() + timeout_s
        while True:
            received = self._receive(deadline)
            if received is None:
                return None
            if isinstance(received, PropertyEvent):
                self._inbox.put(received)
                self._drain()
                return self._inbox.take()
            self._given_up -= 1  # nobody waits for this reply any more

    def _drain(self) -> None:
        """Take what has arrived: of a property of which the latest is wanted, older ones go."""
        quota = _MOST_DRAINED
        while quota > 0:
            try:
                data = self._end.recv(_PIECE, socket.MSG_DONTWAIT)
            except OSError:
                break  # nothing is there; if the connection has ended, whoever waits hears it
            if not data:
                break
            quota -= len(data)
            self._replies.feed(data)
        while (received := self._replies.next()) is not None:
            if isinstance(received, PropertyEvent):
                self._inbox.put(received)
            else:
                self._given_up -= 1

    def listen(self, target: str) -> None:
        """See `PropertyClient.listen`."""
        name, mark, tail = target.partition("?")
        self._inbox.expect(name, tail)
        self.ask(f"{name}.listen{mark}{tail}", "self").value()

    def _quick(self) -> Answer | None:
        """Return what nearly all replies are: one line with a value, and nothing behind it."""
        try:
            data = self._end.recv(_FEW)
        except BlockingIOError:
            self._given_up += 1
            raise Unreachable(f"no answer within {self._timeout_s:g} s") from None
        except OSError:
            return None
        if data[:2] == b"= " and data[2:3] != b"{" and data.find(b"\n") == len(data) - 1:
            return Answer(data[2:-1].decode("utf-8", "surrogateescape"))
        if data == b"=\n":
            return DONE
        if not data:
            raise Unreachable("the connection has ended")
        self._replies.feed(data)
        return None

    def _send(self, data: bytes) -> None:
        try:
            self._end.sendall(data)
        except BlockingIOError:
            raise Unreachable(f"no answer within {self._timeout_s:g} s") from None
        except OSError as error:
            # What it said before it hung up is worth more than that it did.
            if not self._has_received_more():
                raise Unreachable(f"the connection has ended: {error.strerror}") from error

    def _has_received_more(self) -> bool:
        try:
            data = self._end.recv(_PIECE, socket.MSG_DONTWAIT)
        except OSError:
            return False
        if data:
            self._replies.feed(data)
        return bool(data)

    def _receive(self, deadline: float | None) -> tuple[str, Answer] | PropertyEvent | None:
        while True:
            received = self._replies.next()
            if received is not None:
                return received
            left = None if deadline is None else deadline - monotonic()
            # The kernel bounds a wait as long as one for a reply; any other one is bounded here.
            if (left is None or left < self._timeout_s * 0.9) and not self._is_readable(left):
                return None
            try:
                data = self._end.recv(_PIECE)
            except BlockingIOError:
                continue
            except OSError as error:
                raise Unreachable(f"the connection has ended: {error.strerror}") from error
            if not data:
                raise Unreachable("the connection has ended")
            self._replies.feed(data)

    def _is_readable(self, wait_s: float | None) -> bool:
        poll = select.poll()
        try:
            poll.register(self._end, select.POLLIN)
        except ValueError:
            raise Unreachable("the connection has ended: it was closed here") from None
        return bool(poll.poll(None if wait_s is None else max(0, wait_s) * 1000))

    def detach(self) -> socket.socket:
        """Give the connection away, with no request under way; this is of no use any more."""
        return self._end

    def close(self) -> None:
        """End the connection."""
        self._end.close()


def connect_unix(path: str, timeout_s: float) -> LineClient:
    """Connect to a unix socket.

    Raises:
        Unreachable: Nobody of this user listens there.
    """
    try:
        return LineClient(unix.connect(path, timeout_s), timeout_s)
    except OSError as error:
        from rtkit.link.places import service_of, service_socket

        name = service_of(path)
        is_service = path.endswith(".ps") and path == service_socket(name)
        what = f"service {name}" if is_service else path
        raise Unreachable(f"cannot reach {what}: {error.strerror or error}") from error


def connect_tcp(host: str, port: int, timeout_s: float) -> LineClient:
    """Connect to a TCP endpoint with the user's secret.

    Raises:
        Unreachable: Nobody listens there, or there is no secret.
        PropertyError: ``denied``.
    """
    from rtkit.link import secret

    known = secret.read()
    try:
        end = socket.create_connection((host, port), timeout_s)
    except OSError as error:
        raise Unreachable(f"cannot reach {host}:{port}: {error.strerror or error}") from error
    end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    client = LineClient(end, timeout_s)
    try:
        nonce = str(client.ask("door/nonce").value())
        client.ask("door/identity", f"{known.user} {known.proof(nonce)}").value()
    except Exception:
        client.close()
        raise
    return client
