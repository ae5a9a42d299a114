"""Takes the requests that commands send to a manager over a unix socket of its host.

Whoever owns the loop waits for its descriptor among others, so no thread stands between a request
and whoever serves it. See decision 99.
"""

from __future__ import annotations

import logging
import re
import select
import socket
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from threading import Lock

from rtkit.errors import Malformed
from rtkit.link import unix
from rtkit.link.deadline import deadline_from_bytes
from rtkit.link.places import remove_socket
from rtkit.link.requests.frames import GREETING, reply_frame, request_of, take_frame
from rtkit.link.spare_descriptor import SpareDescriptor
from rtkit.property.exchange import Reply, Request

_log = logging.getLogger(__name__)
_NAME = re.compile(r"(@x?)/([^/*$?#\x00-\x20]+(?:/[^/*$?#\x00-\x20]+)*)(?:\?id=([^?]*))?")
_PIECE = 1 << 16
_MOST_WAITING, _MOST_RECEIVED = 1 << 20, 1 << 24
"""How much waits for a client until none of its requests is begun, and how many bytes of those are
kept then: it may send many before it reads an answer [bytes]."""
_BACKLOG = 4096


class RequestServer:
    """Socket of a manager, with those who are connected to it.

    Args:
        path: Of the socket.
        take: Receives each request, on the thread that calls `turn`; it must not raise.
    """

    def __init__(self, path: str, take: Callable[[Request], object]) -> None:
        self._path = path
        self._take = take
        self._listener = unix.listen(path, backlog=_BACKLOG)
        self._listener.setblocking(False)
        self._spare = SpareDescriptor()
        self._epoll = select.epoll()
        self._clients: dict[int, _Client] = {}
        self._epoll.register(self._listener, select.EPOLLIN)

    def fileno(self) -> int:
        """Return a descriptor that can be read when `turn` has something to do."""
        return self._epoll.fileno()

    def turn(self) -> None:
        """Do what can be done now: let clients in, take requests, send what waits."""
        for descriptor, mask in self._epoll.poll(0):
            client = self._clients.get(descriptor)
            if client is not None:
                client.ready(mask)
            elif descriptor == self._listener.fileno():
                self._let_in()

    def _let_in(self) -> None:
        try:
            end, _ = self._listener.accept()
        except BlockingIOError:
            return  # it has gone again
        except OSError as error:
            _log.error("no command can connect: %s", error.strerror)
            with suppress(OSError):  # it waits still, and is turned to again
                self._spare.turn_away(self._listener)
            return
        self._clients[end.fileno()] = _Client(end, self._epoll, self._take, self._clients.pop)

    def close(self) -> None:
        """Hang up; answers that are not taken are lost."""
        self._listener.close()
        remove_socket(self._path)
        for client in list(self._clients.values()):
            client.close()
        self._spare.close()
        self._epoll.close()


class _Client:
    """A connection; answers come from any thread."""

    def __init__(
        self,
        end: socket.socket,
        epoll: select.epoll,
        take: Callable[[Request], object],
        forget: Callable[[int], object],
    ) -> None:
        self._end = end
        self._descriptor = end.fileno()
        self._epoll = epoll
        self._take = take
        self._forget = forget
        self._received = bytearray()
        self._waiting = bytearray()
        self._lock = Lock()
        self._is_open = True
        self._is_behind = False
        self._awaited = select.EPOLLIN
        end.setblocking(False)
        epoll.register(end, self._awaited)
        self._send(GREETING)

    def ready(self, mask: int) -> None:
        """Send and read what can be, and take requests while their answers are read."""
        if mask & select.EPOLLOUT:
            self._send(b"")
        if mask & ~select.EPOLLOUT:
            self._read()
        try:
            is_behind = self._take_requests()
        except Malformed as error:
            _log.warning("a command was hung up on: %s", error)
            self.close()
            return
        with self._lock:
            self._is_behind = is_behind
            self._wait()

    def _take_requests(self) -> bool:
        """Take what has come whole; return whether there may be more, which waits."""
        while self._is_open:
            if len(self._waiting) > _MOST_WAITING:
                return True
            frame = take_frame(self._received)
            if frame is None:
                return False
            self._ask(frame)
        return False

    def _read(self) -> None:
        try:
            data = self._end.recv(_PIECE)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self.close()
            return
        self._received += data

    def _ask(self, frame: bytes) -> None:
        number, name, payload, deadline = request_of(frame)
        answer = partial(self._answer, number)
        known = _NAME.fullmatch(name)
        if known is None:
            answer(Reply(f"not a property: {name}", Malformed.kind))
            return
        mark, rest, id = known.groups()
        try:
            text = None if payload is None else payload.decode()
        except UnicodeDecodeError:
            answer(Reply("payload is not UTF-8 text", Malformed.kind))
            return
        until = deadline_from_bytes(deadline)
        self._take(Request(rest, text, answer, mark == "@x", until, id or ""))

    def _answer(self, number: int, reply: Reply) -> None:
        self._send(reply_frame(number, reply.text, reply.error))

    def _send(self, data: bytes) -> None:
        """Send, after what waits already; what is not taken at once waits."""
        with self._lock:
            if not self._is_open:
                return
            self._waiting += data
            try:
                sent = self._end.send(self._waiting)
                del self._waiting[:sent]
            except BlockingIOError:
                pass
            except OSError:
                self._waiting.clear()  # it has gone, which is read next
            self._wait()

    def _wait(self) -> None:
        """Wait for what can be done next; with the lock."""
        if not self._is_open:
            return
        is_full = self._is_behind and len(self._received) > _MOST_RECEIVED
        reads = 0 if is_full else select.EPOLLIN
        writes = select.EPOLLOUT if self._waiting or self._is_behind else 0
        if reads | writes != self._awaited:
            self._awaited = reads | writes
            self._epoll.modify(self._descriptor, self._awaited)

    def close(self) -> None:
        """Hang up; on the thread of the loop."""
        with self._lock:
            if not self._is_open:
                return
            self._is_open = False
            with suppress(OSError):
                self._epoll.unregister(self._descriptor)
            self._end.close()
        self._forget(self._descriptor)
