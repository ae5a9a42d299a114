"""Streams of port data, and calls of services, between two processes of one host.

They go over direct zenoh links: the receiving process listens on a unix socket of its own and
every sender opens one client session to it, so data flow without the manager and while it is
stopped.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import queue
import struct
import threading
from collections.abc import Callable
from typing import Any
from uuid import uuid4

import zenoh

from rtkit.errors import Unreachable
from rtkit.link import zenoh as control

Deliver = Callable[[bytes], object]
_NUMBER = struct.Struct("<Q")


class Outlet:
    """The sending end of one stream; `put` may be called from any one thread at a time."""

    def __init__(
        self,
        session: zenoh.Session,
        publisher: zenoh.Publisher,
        release: Callable[[], None],
        *,
        is_numbered: bool,
    ) -> None:
        self._session = session
        self._publisher = publisher
        self._release = release
        self._numbers = itertools.count() if is_numbered else None

    def put(self, payload: bytes) -> bool:
        """Send one value; False when the stream is closed."""
        number = None if self._numbers is None else _NUMBER.pack(next(self._numbers))
        try:
            self._publisher.put(payload, attachment=number)
        except (zenoh.ZError, RuntimeError):  # the latter while it is being closed
            return False
        return True

    def flush(self, timeout_s: float) -> bool:
        """Wait until the receiver has everything that was put before; False when it did not tell.

        A mark follows the values, which the receiver sends back when it comes to it.
        """
        key = str(self._publisher.key_expr)
        arrived = threading.Event()
        mark = f"{key}/flushed/{uuid4().hex}"
        try:
            heard = self._session.declare_subscriber(mark, lambda _sample: arrived.set())
            try:
                block = zenoh.CongestionControl.BLOCK
                self._session.put(key, b"", attachment=mark.encode(), congestion_control=block)
                return arrived.wait(timeout_s)
            finally:
                heard.undeclare()  # type: ignore[no-untyped-call]
        except zenoh.ZError:
            return False

    def close(self) -> None:
        """End this end; the other one just hears nothing more."""
        # While another thread is inside `put`, zenoh refuses ("Already borrowed"); the publisher
        # then goes with its last reference.
        with contextlib.suppress(zenoh.ZError, RuntimeError):
            self._publisher.undeclare()  # type: ignore[no-untyped-call]
        self._release()


class Inlet:
    """The end of one stream that listens: it receives values, or is asked for them.

    Attributes:
        lost: Values that were sent and did not arrive, where the sender numbers them.
    """

    def __init__(self) -> None:
        self._declared: zenoh.Subscriber[None] | zenoh.Queryable[None] | None = None
        self._next: int | None = None
        self.lost = 0

    def receive(self, session: zenoh.Session, key: str, deliver: Deliver) -> None:
        """Have `deliver` called with each value from now on."""

        def heard(sample: zenoh.Sample) -> None:
            attachment = sample.attachment
            if attachment is None:
                deliver(sample.payload.to_bytes())
            elif len(attachment) == _NUMBER.size:
                self._count(*_NUMBER.unpack(attachment.to_bytes()))
                deliver(sample.payload.to_bytes())
            else:
                session.put(attachment.to_string(), b"")

        self._declared = session.declare_subscriber(key, heard)

    def answer(self, session: zenoh.Session, key: str, reply: Callable[[], bytes | None]) -> None:
        """Answer with the next value whenever it is asked for from now on."""

        def asked(query: zenoh.Query) -> None:
            with query:
                value = reply()
                if value is not None:
                    query.reply(key, value)

        self._declared = session.declare_queryable(key, asked)

    def _count(self, number: int) -> None:
        if self._next is not None and number > self._next:
            self.lost += number - self._next
        self._next = number + 1

    def close(self) -> None:
        """Take no part in the stream any more."""
        if self._declared is not None:
            with contextlib.suppress(zenoh.ZError):
                self._declared.undeclare()  # type: ignore[no-untyped-call]


class Fetcher:
    """The end of one pull stream that asks for values."""

    def __init__(self, session: zenoh.Session, key: str, release: Callable[[], None]) -> None:
        self._session = session
        self._key = key
        self._release = release

    def fetch(self, timeout_s: float) -> bytes | None:
        """Return the next value, None when the other end has none or is gone."""
        try:
            replies = self._session.get(
                self._key,
                timeout=timeout_s,
                handler=zenoh.handlers.FifoChannel(4),
                consolidation=zenoh.ConsolidationMode.NONE,
            )
        except zenoh.ZError:  # it was closed while the port was being read
            return None
        return next((reply.ok.payload.to_bytes() for reply in replies if reply.ok), None)

    def close(self) -> None:
        """Ask no more."""
        self._release()


class CallEnd:
    """The end of a service connector that is called: answers one call after the other.

    It does so on a thread of its own, which may be inside a provider that never comes back:
    nothing waits for it.
    """

    def __init__(self, key: str, reply_to: Callable[[bytes], bytes]) -> None:
        self._key = key
        self._reply_to = reply_to
        self._queue: queue.SimpleQueue[zenoh.Query | None] = queue.SimpleQueue()
        self._declared: zenoh.Queryable[None] | None = None

    def declare(self, session: zenoh.Session) -> None:
        """Take calls from now on."""
        handler = zenoh.handlers.Callback(self._queue.put, indirect=False)
        threading.Thread(target=self._run, name=f"serve {self._key}", daemon=True).start()
        self._declared = session.declare_queryable(self._key, handler)

    def close(self) -> None:
        """Take no more calls."""
        if self._declared is not None:
            with contextlib.suppress(zenoh.ZError):
                self._declared.undeclare()  # type: ignore[no-untyped-call]
        self._queue.put(None)

    def _run(self) -> None:
        while (query := self._queue.get()) is not None:
            with query, contextlib.suppress(zenoh.ZError):  # who asked may be gone
                request = query.payload.to_bytes() if query.payload is not None else b""
                query.reply(self._key, self._reply_to(request))
            del query  # one that is kept lets its caller wait


class Caller:
    """The end of a service connector that calls."""

    def __init__(self, session: zenoh.Session, key: str, release: Callable[[], None]) -> None:
        self._session = session
        self._key = key
        self._release = release

    def call(self, request: bytes, timeout_s: float) -> bytes:
        """Return the reply to a request.

        Raises:
            Unreachable: There was none in time, or nobody is there any more.
        """
        try:
            replies = self._session.get(
                self._key,
                payload=request,
                timeout=timeout_s,
                handler=zenoh.handlers.FifoChannel(4),
                consolidation=zenoh.ConsolidationMode.NONE,
            )
        except zenoh.ZError as error:  # closed meanwhile
            raise Unreachable("the connection is closed") from error
        for reply in replies:
            if reply.ok is not None:
                return reply.ok.payload.to_bytes()
            raise Unreachable(f"no answer within {timeout_s:g} s")
        raise Unreachable("the provider is gone")

    def close(self) -> None:
        """Call no more."""
        self._release()


class _Sender:
    """The session to one endpoint, shared by all streams that go there."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.session: zenoh.Session | None = None
        self.users = 0


class Streams:
    """All streams of one process; sessions are opened at first use and shared.

    Args:
        pattern: Path of its socket, ``%p`` for the pid of the process that listens.
    """

    def __init__(self, pattern: str) -> None:
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

    def serve(self, key: str, reply_to: Callable[[bytes], bytes]) -> tuple[str, CallEnd]:
        """Answer calls on `key`; return the endpoint for who calls and the connector's end.

        Raises:
            Unreachable: The socket cannot be made.
        """
        end = CallEnd(key, reply_to)
        end.declare(self._listening())
        return self._endpoint, end

    def caller(self, endpoint: str, key: str, timeout_s: float) -> Caller:
        """Open the end of a service connector that calls.

        Raises:
            Unreachable: Nobody listens at `endpoint`.
        """
        session = self._sender(endpoint, timeout_s)
        return Caller(session, key, lambda: self._release(endpoint))

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
        return self._pattern.replace("%p", str(os.getpid()))

    @property
    def _endpoint(self) -> str:
        return control.unix_endpoint(self._path)

    def _listening(self) -> zenoh.Session:
        with self._lock:
            if self._listener is None:
                self._listener = control.open_listener(
                    self._endpoint, "peer", has_shared_memory=True
                )
            return self._listener

    def _sender(self, endpoint: str, timeout_s: float) -> zenoh.Session:
        with self._lock:
            sender = self._senders.setdefault(endpoint, _Sender())
            sender.users += 1
        with sender.lock:  # an endpoint that does not answer holds up nobody else
            if sender.session is None:
                try:
                    sender.session = control.open_client(
                        endpoint, timeout_s, has_shared_memory=True
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


def remove_socket(path: str) -> None:
    """Remove a socket and the lock file that zenoh lays beside it."""
    for name in (path, path + ".lock"):
        with contextlib.suppress(FileNotFoundError):
            os.unlink(name)
