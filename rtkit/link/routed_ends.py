"""Ends of connectors between processes of two hosts, over zenoh."""

from __future__ import annotations

import contextlib
import queue
import struct
import threading
from collections.abc import Callable
from uuid import uuid4

import zenoh

from rtkit.errors import Unreachable
from rtkit.link.ends import (
    CallerEnd,
    Deliver,
    Fetcher,
    Inlet,
    Octets,
    Outlet,
    Payload,
    joined,
)
from rtkit.link.threads import start_thread
from rtkit.link.zenoh import ask

_NUMBER = struct.Struct("<Q")
_TOTAL = b"="
"""Prefix of a number that is a total, not that of a value."""


def _question(key: object) -> str:
    """Return the key on which a sender is asked how many values it has sent."""
    return f"{key}/sent"


def _undeclare(
    declared: zenoh.Subscriber[None] | zenoh.Queryable[None] | zenoh.Publisher | None,
) -> None:
    # While another thread is inside `put`, zenoh refuses ("Already borrowed"); a publisher then
    # goes with its last reference.
    with contextlib.suppress(zenoh.ZError, RuntimeError):
        if declared is not None:
            declared.undeclare()  # type: ignore[no-untyped-call]


class RoutedOutlet(Outlet):
    """Sending end of one stream."""

    def __init__(
        self,
        session: zenoh.Session,
        publisher: zenoh.Publisher,
        *,
        is_numbered: bool,
    ) -> None:
        self._session = session
        self._publisher = publisher
        self._is_numbered = is_numbered
        self._sent = 0
        self._asked: zenoh.Subscriber[None] | None = None
        if is_numbered:
            self._asked = session.declare_subscriber(_question(publisher.key_expr), self._answer)

    def put(self, payload: Payload) -> bool:
        """See `Outlet.put`."""
        number = _NUMBER.pack(self._sent) if self._is_numbered else None
        self._sent += 1
        try:
            self._publisher.put(joined(payload), attachment=number)
        except (zenoh.ZError, RuntimeError):  # the latter while it is being closed
            return False
        return True

    def flush(self, timeout_s: float) -> bool:
        """See `Outlet.flush`.

        A mark follows the values, which the receiver sends back when it comes to it.
        """
        key = str(self._publisher.key_expr)
        arrived = threading.Event()
        mark = f"{key}/flushed/{uuid4().hex}"
        try:
            on_sample = self._session.declare_subscriber(mark, lambda _sample: arrived.set())
            try:
                block = zenoh.CongestionControl.BLOCK
                self._session.put(key, b"", attachment=mark.encode(), congestion_control=block)
                return arrived.wait(timeout_s)
            finally:
                on_sample.undeclare()  # type: ignore[no-untyped-call]
        except zenoh.ZError:
            return False

    def _answer(self, _sample: zenoh.Sample) -> None:
        """Send how many values were sent before, in their row, so that it comes after them."""
        with contextlib.suppress(zenoh.ZError, RuntimeError):
            self._session.put(
                self._publisher.key_expr,
                b"",
                attachment=_TOTAL + _NUMBER.pack(self._sent),
                congestion_control=zenoh.CongestionControl.BLOCK,
            )

    def close(self) -> None:
        """See `Outlet.close`."""
        _undeclare(self._asked)
        _undeclare(self._publisher)


class RoutedInlet(Inlet):
    """Receiving end of one stream: values are pushed to it, or asked of it."""

    def __init__(self) -> None:
        self._declared: zenoh.Subscriber[None] | zenoh.Queryable[None] | None = None
        self._ask: Callable[[], None] | None = None
        self._is_reported = threading.Event()
        self._next = 0
        self.lost = 0

    def receive(self, session: zenoh.Session, key: str, deliver: Deliver) -> None:
        """Call `deliver` with each value from now on."""

        def on_sample(sample: zenoh.Sample) -> None:
            attachment = sample.attachment
            if attachment is None:
                deliver(sample.payload.to_bytes())
            elif len(attachment) == _NUMBER.size:
                self._count(*_NUMBER.unpack(attachment.to_bytes()))
                self._next += 1
                deliver(sample.payload.to_bytes())
            elif len(attachment) == _NUMBER.size + len(_TOTAL):
                self._count(*_NUMBER.unpack(attachment.to_bytes()[len(_TOTAL) :]))
                self._is_reported.set()
            else:
                session.put(attachment.to_string(), b"")

        self._declared = session.declare_subscriber(key, on_sample)
        self._ask = lambda: session.put(_question(key), b"")

    def settle(self, timeout_s: float) -> bool:
        """See `Inlet.settle`."""
        if self._ask is None:
            return False
        self._is_reported.clear()
        try:
            self._ask()
        except zenoh.ZError:
            return False
        return self._is_reported.wait(timeout_s)

    def answer(self, session: zenoh.Session, key: str, reply: Callable[[], Octets | None]) -> None:
        """Answer with the next value whenever it is asked for from now on."""

        def asked(query: zenoh.Query) -> None:
            with query:
                value = reply()
                if value is not None:
                    query.reply(key, bytes(value))

        self._declared = session.declare_queryable(key, asked)

    def _count(self, number: int) -> None:
        if number > self._next:
            self.lost += number - self._next
        self._next = number

    def close(self) -> None:
        """See `Inlet.close`."""
        _undeclare(self._declared)


class _AskingEnd:
    """End of a connector that asks the other one."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._session = session
        self._key = key

    def close(self) -> None:
        """Ask no more; the session is that of other streams, too."""


class RoutedFetcher(_AskingEnd, Fetcher):
    """Asking end of one pull stream."""

    def fetch(self, timeout_s: float) -> bytes | None:
        """See `Fetcher.fetch`."""
        try:
            replies = ask(self._session, self._key, timeout_s)
        except zenoh.ZError:  # it was closed while the port was being read
            return None
        return next((reply.ok.payload.to_bytes() for reply in replies if reply.ok), None)


class ProviderEnd:
    """Provider's end of a service connector: answers one call after the other.

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
        start_thread(self._run, f"serve {self._key}")
        self._declared = session.declare_queryable(self._key, handler)

    def close(self) -> None:
        """Take no more calls."""
        _undeclare(self._declared)
        self._queue.put(None)

    def _run(self) -> None:
        while (query := self._queue.get()) is not None:
            with query, contextlib.suppress(zenoh.ZError):  # the requester may be gone
                request = query.payload.to_bytes() if query.payload is not None else b""
                query.reply(self._key, self._reply_to(request))
            del query  # one that is kept lets its caller wait


class RoutedCaller(_AskingEnd, CallerEnd):
    """Caller's end of a service connector."""

    def call(self, request: bytes, timeout_s: float) -> bytes:
        """See `CallerEnd.call`."""
        try:
            replies = ask(self._session, self._key, timeout_s, request)
        except zenoh.ZError as error:  # closed meanwhile
            raise Unreachable("the connection is closed") from error
        for reply in replies:
            if reply.ok is not None:
                return reply.ok.payload.to_bytes()
            raise Unreachable(f"no answer within {timeout_s:g} s")
        raise Unreachable("the provider is gone")
