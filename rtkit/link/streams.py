"""Streams of port data, and calls of services, between two processes of one host.

They go over direct zenoh links: the receiving process listens on a unix socket of its own and
every sender opens one client session to it, so data flow without the manager and while it is
stopped. Large values go through shared memory; where none can be had, all go through the socket.

See decision 3.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable
from typing import Any

import zenoh

from rtkit.errors import Unreachable
from rtkit.link import zenoh as control
from rtkit.link.ends import CallerEnd, Deliver, Fetcher, Inlet, Outlet, ProviderEnd
from rtkit.link.places import of_pid


class _Sender:
    """Session to one endpoint, shared by all streams that go there."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.session: zenoh.Session | None = None
        self.users = 0


class Streams:
    """Opens all streams of one process; sessions are opened at first use and shared.

    Args:
        pattern: Path of its socket, ``%p`` for the pid of the process that listens.

    Attributes:
        slow: Why large values go without shared memory, empty while they go through it.
        report: Is told that once, in one line.
    """

    def __init__(self, pattern: str) -> None:
        self.slow = ""
        self.report: Callable[[str], object] = _ignore
        self._pattern = pattern
        self._listener: zenoh.Session | None = None
        self._senders: dict[str, _Sender] = {}
        self._lock = threading.Lock()

    def receive(self, key: str, deliver: Deliver) -> tuple[str, Inlet]:
        """Listen on `key`; return the endpoint for the sender and the stream's end.

        `deliver` is called on a thread of the stream, one value after the other.

        Raises:
            Unreachable: The socket cannot be made.
        """
        inlet = Inlet()
        inlet.receive(self._listening(), key, deliver)
        return self._endpoint, inlet

    def answer(self, key: str, next_value: Callable[[], bytes | None]) -> tuple[str, Inlet]:
        """Be asked for values on `key`; return the endpoint for who asks and the stream's end.

        Raises:
            Unreachable: The socket cannot be made.
        """
        inlet = Inlet()
        inlet.answer(self._listening(), key, next_value)
        return self._endpoint, inlet

    def ask(self, endpoint: str, key: str, timeout_s: float) -> Fetcher:
        """Open the end of a pull stream that asks.

        Raises:
            Unreachable: Nobody listens at `endpoint`.
        """
        session = self._sender(endpoint, timeout_s)
        return Fetcher(session, key, lambda: self._release(endpoint))

    def serve(self, key: str, reply_to: Callable[[bytes], bytes]) -> tuple[str, ProviderEnd]:
        """Answer calls on `key`; return the endpoint for who calls and the connector's end.

        Raises:
            Unreachable: The socket cannot be made.
        """
        end = ProviderEnd(key, reply_to)
        end.declare(self._listening())
        return self._endpoint, end

    def caller(self, endpoint: str, key: str, timeout_s: float) -> CallerEnd:
        """Open the end of a service connector that calls.

        Raises:
            Unreachable: Nobody listens at `endpoint`.
        """
        session = self._sender(endpoint, timeout_s)
        return CallerEnd(session, key, lambda: self._release(endpoint))

    def send(
        self,
        endpoint: str,
        key: str,
        timeout_s: float,
        *,
        is_blocking: bool = False,
        is_numbered: bool = False,
    ) -> Outlet:
        """Open the sending end of a stream; returns when the receiver was found.

        A blocking one waits where another would lose values. One that numbers its values lets the
        receiver count what is lost.

        Raises:
            Unreachable: It was not, within `timeout_s` [s].
        """
        session = self._sender(endpoint, timeout_s)
        congestion = zenoh.CongestionControl.BLOCK if is_blocking else zenoh.CongestionControl.DROP
        publisher = session.declare_publisher(key, congestion_control=congestion)
        outlet = Outlet(
            session, publisher, lambda: self._release(endpoint), is_numbered=is_numbered
        )
        matched = threading.Event()

        def changed(status: zenoh.MatchingStatus) -> None:
            if status.matching:
                matched.set()

        listener = publisher.declare_matching_listener(changed)
        status: Any = publisher.matching_status  # the stubs of zenoh 1.10 say bool, wrongly
        is_matched = status.matching or matched.wait(timeout_s)
        listener.undeclare()  # type: ignore[no-untyped-call]
        if not is_matched:
            outlet.close()
            raise Unreachable(f"nobody takes data at {endpoint}")
        return outlet

    def close(self) -> None:
        """End every stream."""
        with self._lock:
            sessions = [sender.session for sender in self._senders.values()]
            sessions.append(self._listener)
            self._senders.clear()
            self._listener = None
        for session in sessions:
            if session is not None:
                session.close()  # type: ignore[no-untyped-call]
        remove_socket(self._path)

    @property
    def _path(self) -> str:
        return of_pid(self._pattern, os.getpid())

    @property
    def _endpoint(self) -> str:
        return control.unix_endpoint(self._path)

    def _listening(self) -> zenoh.Session:
        with self._lock:
            if self._listener is None:
                self._listener = self._fastest(self._listen, 0.0)
            return self._listener

    def _listen(self, has_shared_memory: bool, _timeout_s: float) -> zenoh.Session:
        try:
            return control.open_listener(
                self._endpoint, "peer", has_shared_memory=has_shared_memory
            )
        except Unreachable:
            remove_socket(self._path)  # a half-made end keeps its lock until this process ends
            raise

    def _fastest(
        self, open: Callable[[bool, float], zenoh.Session], timeout_s: float
    ) -> zenoh.Session:
        """Open a session with shared memory, or without where that cannot be had.

        Zenoh refuses a session altogether where ``/dev/shm`` is missing, full or read-only.
        """
        until = time.monotonic() + timeout_s
        try:
            return open(True, timeout_s)
        except Unreachable as error:
            left_s = until - time.monotonic()
            if timeout_s and left_s <= 0:
                raise
            session = open(False, left_s)
            if not self.slow:
                self.slow = str(error)
                self.report(f"large values go without shared memory, which is slower: {error}")
            return session

    def _sender(self, endpoint: str, timeout_s: float) -> zenoh.Session:
        with self._lock:
            sender = self._senders.setdefault(endpoint, _Sender())
            sender.users += 1
        with sender.lock:  # an endpoint that does not answer holds up nobody else
            if sender.session is None:
                try:
                    sender.session = self._fastest(
                        lambda has_shared_memory, left_s: control.open_client(
                            endpoint, left_s, has_shared_memory=has_shared_memory
                        ),
                        timeout_s,
                    )
                except Unreachable:
                    self._release(endpoint)
                    raise
            return sender.session

    def _release(self, endpoint: str) -> None:
        with self._lock:
            sender = self._senders.get(endpoint)
            if sender is None:
                return
            sender.users -= 1
            if sender.users:
                return
            del self._senders[endpoint]
        if sender.session is not None:
            sender.session.close()  # type: ignore[no-untyped-call]


def _ignore(text: str) -> None:
    """Ignore a call."""


def remove_socket(path: str) -> None:
    """Remove a socket and the lock file that zenoh lays beside it."""
    for name in (path, path + ".lock"):
        with contextlib.suppress(FileNotFoundError):
            os.unlink(name)
