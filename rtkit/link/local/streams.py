"""Streams of port data, and calls of services, between two processes of one host.

The receiving process listens on a unix socket of its own, and every connector has a connection to
it, so data flow without the manager and while it is stopped. Large values go through shared memory.

See decision 91.
"""

from __future__ import annotations

import os
import select
import socket
import struct
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from weakref import WeakSet

from rtkit.errors import Refused, Unreachable
from rtkit.link import places, unix
from rtkit.link.ends import (
    CallerEnd,
    ConnectorEnd,
    Deliver,
    Fetcher,
    Inlet,
    Octets,
    Outlet,
    Streams,
)
from rtkit.link.local.channel import Channel, take_passed
from rtkit.link.local.inlet import LocalInlet
from rtkit.link.local.loop import SocketLoop
from rtkit.link.local.outlet import LocalOutlet
from rtkit.link.local.requests import AnsweringEnd, LocalCaller, LocalFetcher
from rtkit.link.local.sent_count import SentCount
from rtkit.link.local.slots import SlotPool

_HELLO = b"rtkit data 2\n"
_WELCOME, _UNKNOWN = b"\1", b"\0"
_MOST_HELLO = 4096
_BUFFER = 1 << 20
"""How much a socket is asked to hold [bytes]; the system may allow less."""
_BACKLOG = 128


class LocalStreams(Streams):
    """All streams of one process to others of this host; its socket is made at first use.

    Args:
        pattern: Path of its socket, ``%p`` for the pid of the process that listens.
    """

    def __init__(self, pattern: str) -> None:
        super().__init__()
        self._pattern = pattern
        self._pool = SlotPool()
        self._loop: SocketLoop | None = None
        self._listener: socket.socket | None = None
        self._ends: dict[str, LocalInlet | AnsweringEnd] = {}
        self._outgoing: WeakSet[Channel] = WeakSet()
        self._lock = threading.Lock()

    def receive(self, key: str, deliver: Deliver, *, is_patient: bool = False) -> tuple[str, Inlet]:
        """See `Streams.receive`."""
        loop = SocketLoop(f"data {key}") if is_patient else self._common_loop()
        inlet = LocalInlet(deliver, loop, partial(self._forget, key), owns_loop=is_patient)
        return self._listen(key, inlet), inlet

    def answer(self, key: str, next_value: Callable[[], Octets | None]) -> tuple[str, ConnectorEnd]:
        """See `Streams.answer`."""
        lock = threading.Lock()

        def taken(_request: bytes) -> Octets | None:
            with lock:
                return next_value()

        end = AnsweringEnd(taken, partial(self._forget, key))
        return self._listen(key, end), end

    def serve(self, key: str, reply_to: Callable[[bytes], bytes]) -> tuple[str, ConnectorEnd]:
        """See `Streams.serve`."""
        end = AnsweringEnd(reply_to, partial(self._forget, key))
        return self._listen(key, end), end

    def send(
        self,
        endpoint: str,
        key: str,
        timeout_s: float,
        *,
        is_blocking: bool = False,
        is_numbered: bool = False,
    ) -> Outlet:
        """See `Streams.send`."""
        passed: list[int] = []
        sent = None
        try:
            if is_numbered:
                passed.append(os.memfd_create("rtkit", os.MFD_CLOEXEC))
                os.ftruncate(passed[0], SentCount.SIZE)
                sent = SentCount(passed[0])
            channel = self._connect(endpoint, key, timeout_s, passed)
        finally:
            for descriptor in passed:
                os.close(descriptor)
        loop = self._common_loop()
        return LocalOutlet(
            channel, loop, is_blocking=is_blocking, sent=sent, report=lambda text: self.report(text)
        )

    def ask(self, endpoint: str, key: str, timeout_s: float) -> Fetcher:
        """See `Streams.ask`."""
        return LocalFetcher(self._connect(endpoint, key, timeout_s))

    def caller(self, endpoint: str, key: str, timeout_s: float) -> CallerEnd:
        """See `Streams.caller`."""
        another = partial(self._connect, endpoint, key)
        return LocalCaller(another(timeout_s), another)

    def close(self) -> None:
        """See `Streams.close`."""
        with self._lock:
            listener, loop = self._listener, self._loop
            self._listener = self._loop = None
            ends = [*self._ends.values(), *self._outgoing]
        if listener is not None:
            if loop is not None:
                loop.remove(listener.fileno())
            listener.close()
            places.remove_socket(self._path)
        for end in ends:
            end.close()
        if loop is not None:
            loop.close()
        self._pool.close()

    @property
    def _path(self) -> str:
        return places.of_pid(self._pattern, os.getpid())

    def _common_loop(self) -> SocketLoop:
        with self._lock:
            if self._loop is None:
                self._loop = SocketLoop("data")
            return self._loop

    # incoming

    def _listen(self, key: str, end: LocalInlet | AnsweringEnd) -> str:
        loop, path = self._common_loop(), self._path
        with self._lock:
            self._ends[key] = end
            if self._listener is None:
                try:
                    self._listener = self._listened(path, loop)
                except BaseException:
                    del self._ends[key]
                    raise
        return path

    def _listened(self, path: str, loop: SocketLoop) -> socket.socket:
        try:
            listener = unix.listen(path, keeps_packets=True, backlog=_BACKLOG)
        except OSError as error:
            raise Unreachable(f"cannot listen on {path}: {error.strerror or error}") from error
        try:
            listener.setblocking(False)
            loop.add(listener.fileno(), self._accept, select.EPOLLIN)
        except BaseException:
            listener.close()
            places.remove_socket(path)
            raise
        return listener

    def _forget(self, key: str) -> None:
        with self._lock:
            self._ends.pop(key, None)

    def _accept(self) -> None:
        listener, loop = self._listener, self._loop
        if listener is None or loop is None:
            return
        try:
            connection, _ = listener.accept()
        except OSError:  # it has gone again, or there are too many files: it tries again
            return
        connection.setblocking(True)
        if unix.user_of(connection) not in (0, os.geteuid()):
            connection.close()
            return
        loop.add(connection.fileno(), lambda: self._greet(connection, loop), select.EPOLLIN)

    def _greet(self, connection: socket.socket, loop: SocketLoop) -> None:
        """Join a connection with the end that it is for."""
        loop.remove(connection.fileno())
        try:
            data, passed, *_ = connection.recvmsg(
                _MOST_HELLO, socket.CMSG_SPACE(4), socket.MSG_DONTWAIT | socket.MSG_CMSG_CLOEXEC
            )
        except OSError:
            connection.close()
            return
        descriptors = take_passed(passed, most=1)
        try:
            self._join(connection, data, descriptors)
        finally:
            for descriptor in descriptors:
                os.close(descriptor)

    def _join(self, connection: socket.socket, data: bytes, descriptors: list[int]) -> None:
        key = data.removeprefix(_HELLO).decode(errors="replace")
        end = self._ends.get(key) if data.startswith(_HELLO) else None
        channel = Channel(connection, self._pool)
        is_known = False
        try:
            if isinstance(end, LocalInlet):
                is_known = end.connect(channel, SentCount(descriptors[0]) if descriptors else None)
            elif end is not None:
                is_known = end.connect(channel, key)
            channel.connection.send(_WELCOME if is_known else _UNKNOWN, socket.MSG_NOSIGNAL)
        except (OSError, ValueError, Refused):
            channel.close()
        if not is_known:
            channel.close()

    # outgoing

    def _connect(
        self, endpoint: str, key: str, timeout_s: float, passed: Sequence[int] = ()
    ) -> Channel:
        until = time.monotonic() + timeout_s
        try:
            connection = unix.connect(endpoint, timeout_s, keeps_packets=True)
        except OSError as error:
            raise Unreachable(f"nobody takes data at {endpoint}: {error.strerror}") from error
        try:
            connection.settimeout(None)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER)
            _bound(connection, until - time.monotonic())
            socket.send_fds(connection, [_HELLO + key.encode()], passed)
            answer = connection.recv(1)
        except OSError as error:
            connection.close()
            raise Unreachable(f"nobody takes data at {endpoint}") from error
        if answer != _WELCOME:
            connection.close()
            raise Unreachable(f"nobody takes data at {endpoint}")
        _bound(connection, None)
        channel = Channel(connection, self._pool)
        self._outgoing.add(channel)
        return channel


def _bound(connection: socket.socket, bound_s: float | None) -> None:
    """Have each wait at a socket end after so long at most [s]; None: never."""
    bound_us = 0 if bound_s is None else max(1, int(bound_s * 1e6))
    bound = struct.pack("@ll", *divmod(bound_us, 1_000_000))
    for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
        connection.setsockopt(socket.SOL_SOCKET, option, bound)
