"""One client of the line protocol: its requests, replies in order, its events; bounded.

Limits: a line, what waits to be sent, how long half a line may be, how long nothing is read.
"""

from __future__ import annotations

import os
import select
import socket
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING

from rtkit.link import unix
from rtkit.link.deadline import split_deadline
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.line import LineRequest, Requests, write_answer, write_event
from rtkit.property.messages import Answer, PropertyEvent
from rtkit.property.reply_order import InOrder
from rtkit.property.requests import PropertyRequest
from rtkit.property.subscription import Listener
from rtkit.serving.dedicated_worker import WorkerExit
from rtkit.serving.quota import too_fast
from rtkit.serving.socket_client import SocketClient

if TYPE_CHECKING:
    from rtkit.serving.event_loop import ByteStream, PropertyEventLoop
    from rtkit.serving.quota import EndpointQuota
    from rtkit.wires.line.login import Login

_PIECE = 1 << 16
_FEW = 1 << 12
"""Bytes that are enough for most requests: a larger buffer costs time to make."""
_HIGH = 1 << 18
"""Bytes that wait to be sent, above which no further request is taken."""
_ROOM_FOR_EVENTS = 1 << 15
HALF_S = 30.0
"""How long half a request, or a reply that nobody reads, is waited for [s]."""
_MOST_WAITING = 4096
"""Requests that are being worked on for one connection."""
IN_A_ROW = 32
"""Requests one by one, between two looks at the client, for which it is given a thread."""


class Connection(SocketClient):
    """Client behind a socket, or behind something that behaves as one.

    Args:
        host: Whose loop serves it.
        end: The socket.
        service: The one that is meant where no other is named.
        login: Asks who it is; None where the kernel has told.
        quota: How much there is room for, and what may be done.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        end: ByteStream,
        service: str,
        identity: str,
        login: Login | None,
        quota: EndpointQuota,
    ) -> None:
        super().__init__(host, end, quota, identity)
        self._service = service
        self._login = login
        self._requests = Requests(self._longest)
        self._order = InOrder(self._put)
        self._is_half = False
        self._has_left = False
        self._in_a_row = 0
        self._is_attended = False

    # IOHandler

    def ready(self, mask: int) -> bool:
        """See `IOHandler.ready`."""
        if mask & select.EPOLLOUT:
            self._send()
        if mask & ~select.EPOLLOUT and self.is_open:
            self._has_left |= bool(mask & select.EPOLLHUP)
            data = self._receive(_PIECE if self._is_half else _FEW)
            if not data:
                return False
            if self._is_one(data) and self._is_answered(data):
                return not self._out
            self._moved_at = monotonic()
            self._requests.feed(data)
        if self.is_open:
            self._work()
        return False

    def _is_one(self, data: bytes) -> bool:
        """Return whether this is one request of a known client that waits for nothing else."""
        if self._out or self._is_half or self._order.waiting or self._is_closing:
            return False
        is_whole = data.find(b"\n") == len(data) - 1 and len(data) <= self._longest
        return is_whole and data[:1] != b"#" and bool(self.identity) and self._pace is None

    def _is_answered(self, data: bytes) -> bool:
        """Have one request answered by who does it soonest; return whether there is nothing more.

        Decision 34: who asks one thing after the other gets a thread that waits for it alone.
        """
        self._in_a_row += 1
        if self._in_a_row > IN_A_ROW and not self.listeners:
            self._is_attended = self._host.attend(self._end, data, self._attended, self._take_back)
            if self._is_attended:
                return True
        reply = self._reply_at_once(data)
        if reply is None:
            return False
        try:
            sent = self._end.send(reply)
        except OSError:
            sent = 0
        if sent < len(reply) or self.listeners:
            self._out += reply[sent:]
            self._moved_at = monotonic()
            self._send()
        return True

    def _reply_at_once(self, data: bytes) -> bytes | None:
        """Return the reply to one line that takes only a look; None if this is another request."""
        if data.find(b"\n") != len(data) - 1 or len(data) > self._longest:
            return None
        service = self._host.services.get(self._service)
        return None if service is None else service.quick(data, self)

    def _attended(self, data: bytes) -> bytes | None:
        """Return what is to be sent for what came to the worker of this client; None to end it."""
        reply = self._reply_at_once(data)
        if reply is not None:
            return reply
        is_one = self._is_one(data)
        self._requests.feed(data)
        asked = self._requests.next() if is_one else None
        if asked is None:
            return None
        self._is_working = True
        self._take(asked)
        self._is_working = False
        if not self._is_attended or self._order.waiting or self.listeners or self._is_closing:
            return None
        reply = bytes(self._out)
        self._out.clear()
        return reply

    def _take_back(self, left: WorkerExit) -> None:
        """Serve on after a dedicated worker."""
        self._is_attended = False
        self._in_a_row = 0
        self._moved_at = monotonic()
        self._out += left.unsent
        if left.has_gone:
            self.close()
        else:
            self._work()

    def _work(self) -> None:
        """Take the requests that are there, as long as replies are read."""
        self._is_working = True
        while self.is_open and not (self._is_closing or self._is_full()):
            asked = self._requests.next()
            if asked is None:
                break
            self._take(asked)
        self._is_working = False
        self._is_half = self._requests.waits
        self._send()

    def _is_full(self) -> bool:
        return len(self._out) > _HIGH or self._order.waiting > _MOST_WAITING

    def _take(self, asked: LineRequest) -> None:
        id = asked.id
        send = self._order.expect(has_id=bool(id))

        def answer(reply: Answer) -> None:
            send(write_answer(reply, id))

        if asked.error is not None:
            answer(Answer(str(asked.error), asked.error.code))
            self._is_closing = asked.is_last
        elif self._pace is not None and not self._pace.takes(monotonic()):
            answer(Answer(too_fast(self._quota.limits.rate), "busy"))
        else:
            self._dispatch(asked, answer)

    def _write(self, message: bytes) -> None:
        """Send a reply or an event."""
        self._out += message

    def _put(self, reply: bytes) -> None:
        self._write(reply)
        if not self._is_working and self.is_open:
            self._host.mark(self)

    def _dispatch(self, asked: LineRequest, answer: Callable[[Answer], None]) -> None:
        target, name = asked.target, self._service
        path = target.partition("?")[0]
        if "/" in path:
            name, _, rest = path.rpartition("/")
            target = rest + target[len(path) :]
        if self._login is not None and (name == "door" or not self.identity):
            reply = self._login.take(self, name, target, asked.payload)
            answer(reply)
            self._is_closing = self._login.is_refused
            return
        service = self._host.services.get(name)
        if service is None:
            answer(Answer(f"no such service: {name}", "no-service"))
            return
        if self._has_left and "timeout=" in target:
            # The client's time-out is over, and it has reported to its user that nothing was done.
            answer(Answer(NOT_BEGUN, "timeout"))
            return
        target, until = split_deadline(target)
        if asked.payload is not None and monotonic() > until:
            answer(Answer(NOT_BEGUN, "timeout"))
            return
        ask = PropertyRequest(target, asked.payload, answer, self, asked.id, until)
        service.handle(self.audited(ask, name))

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`."""
        due = self.send_due(now, self._has_room, self._send_event)
        is_full = not self._has_room()  # and events wait, perhaps
        if self._is_half:
            self._work()
        elif not self._send_out() or self._out or self._is_closing or is_full:
            self._send()
        return due if self.is_open else None

    def _has_room(self) -> bool:
        return len(self._out) < _ROOM_FOR_EVENTS

    def _send_event(self, listener: Listener, event: PropertyEvent) -> None:
        self._write(write_event(event))

    def check(self, now: float) -> None:
        """See `IOHandler.check`."""
        self._in_a_row = 0
        is_half = self._requests.waits or bool(self._out)
        login = self._login
        if (is_half and now - self._moved_at > HALF_S) or (
            login is not None and not self.identity and now > login.ends_at
        ):
            self.close()

    def _send(self) -> None:
        if not self._send_out():
            return
        if self._is_closing and not self._out:
            self.close()
            return
        self._await(reads=not (self._is_closing or self._is_full()))
        if self.listeners and not self._out and self.has_pending:
            self._host.mark(self)


def peer(end: socket.socket) -> str:
    """Return the peer of a unix socket, as the kernel reports it; empty if another user.

    Raises:
        OSError: The socket is gone.
    """
    uid = unix.user_of(end)
    return f"uid-{uid}" if uid == os.getuid() else ""
