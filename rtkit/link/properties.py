"""Properties over zenoh: a service answers queries and sends events, a client asks and listens.

A query without payload is a GET, one with it a SET. A listener has a key of its own, subscribes to
it, and asks the service to send there; it asks again before its lease is over, and is then sent the
last event once more, so that what the transport may drop under load is never the last value.
"""

from __future__ import annotations

import threading
import time
import uuid
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

import zenoh

from rtkit.errors import Unreachable
from rtkit.link import keys
from rtkit.link.zenoh import _ERROR_ENCODING as ERROR_ENCODING
from rtkit.property.codes import PropertyError
from rtkit.property.line import read_event, write_attributes
from rtkit.property.messages import Answer, Event, Payload
from rtkit.property.naming import parse_target

LEASE_S = 10.0
"""How long a listener is served that is not heard of again [s]."""
_BYTES = zenoh.Encoding.APPLICATION_OCTET_STREAM
_EAR = "ear"
_SHORT = 256
_MOST_KNOWN = 4096
"""Targets of which a client remembers the keys, and how long they may be."""


class Queried(NamedTuple):
    """A query as the service takes it.

    Attributes:
        ear: The listener that the request is about, if it is one of `Ears`.
    """

    target: str
    payload: Payload | None
    answer: Callable[[Answer], None]
    ear: str


class PropertyDoor:
    """Answers queries for one service on a session, and sends its events."""

    def __init__(
        self, session: zenoh.Session, service_key: str, take: Callable[[Queried], object]
    ) -> None:
        self._session = session
        self._key = service_key
        self._declared: list[zenoh.Queryable[None]] = []
        for mark, is_extension in (("@", False), ("@x", True)):
            prefix = f"{service_key}/{mark}/"
            receive = _receiver(prefix, is_extension, take)
            handler = zenoh.handlers.Callback(receive, indirect=False)
            self._declared.append(session.declare_queryable(prefix + "**", handler))

    def send(self, ear: str, event: Event) -> None:
        """Send an event to a listener; nobody is waited for."""
        attributes = f"{write_attributes(event)};name={event.name}"
        encoding = _BYTES if isinstance(event.payload, bytes) else None
        key = ear_key(self._key, ear)
        self._session.put(key, event.payload, attachment=attributes, encoding=encoding)

    def close(self) -> None:
        """Answer nothing any more, and end the session."""
        while self._declared:
            self._declared.pop().undeclare()  # type: ignore[no-untyped-call]
        self._session.close()  # type: ignore[no-untyped-call]


def _receiver(
    prefix: str, is_extension: bool, take: Callable[[Queried], object]
) -> Callable[[zenoh.Query], None]:
    def receive(query: zenoh.Query) -> None:
        key = str(query.key_expr)

        def answer(reply: Answer) -> None:
            if reply.error:
                query.reply_err(f"{reply.error} {reply.payload!s}", encoding=ERROR_ENCODING)
            elif isinstance(reply.payload, bytes):
                query.reply(key, reply.payload, encoding=_BYTES)
            else:
                query.reply(key, reply.payload)
            query.drop()  # type: ignore[no-untyped-call]

        target = keys.to_target(key.removeprefix(prefix), is_extension=is_extension)
        target, ear = _with_parameters(target, str(query.parameters))
        take(Queried(target, _payload(query.payload), answer, ear))

    return receive


def _with_parameters(target: str, parameters: str) -> tuple[str, str]:
    if not parameters:
        return target, ""
    kept, ear = [], ""
    for each in parameters.split(";"):
        key, _, value = each.partition("=")
        if key == _EAR:
            ear = value
        else:
            kept.append(each)
    return (f"{target}?{'&'.join(kept)}" if kept else target), ear


def _payload(payload: zenoh.ZBytes | None) -> Payload | None:
    if payload is None:
        return None
    try:
        return payload.to_string()
    except ValueError:  # which is what zenoh raises for what is no UTF-8
        return payload.to_bytes()


def selector_of(service_key: str, target: str) -> str:
    """Return what is asked for a target.

    Raises:
        PropertyError: No key can be made of it.
    """
    asked = parse_target(target)
    parameters = target.partition("?")[2].replace("&", ";")
    key = keys.of_target(service_key, asked.name)
    return f"{key}?{parameters}" if parameters else key


def for_ear(selector: str, ear: str) -> str:
    """Return what is asked so that it is about one listener."""
    return f"{selector}{';' if '?' in selector else '?'}{_EAR}={ear}"


def ear_key(service_key: str, ear: str) -> str:
    """Return the key on which events are sent to a listener."""
    return f"{service_key}/@e/{ear}"


def answer_of(reply: zenoh.Reply, timeout_s: float) -> Answer:
    """Return the answer that a reply carries.

    Raises:
        Unreachable: It says that there was none in time.
    """
    if reply.ok is not None:
        return Answer(_content(reply.ok))
    error = reply.err
    if error is None or error.encoding != ERROR_ENCODING:
        raise Unreachable(f"no answer within {timeout_s:g} s")
    code, _, message = error.payload.to_string().partition(" ")
    return Answer(message, code)


def event_of(sample: zenoh.Sample) -> Event:
    """Return the event that a sample carries."""
    attachment = sample.attachment
    text = "" if attachment is None else attachment.to_string()
    head, _, name = text.partition(";name=")
    return read_event(name, _content(sample), head)


def _content(sample: zenoh.Sample) -> Payload:
    if sample.encoding == _BYTES:
        return sample.payload.to_bytes()
    return sample.payload.to_string()


class PropertyClient:
    """Asks one service over a session that others may use too.

    Args:
        timeout_s: Bound on each request [s].
    """

    def __init__(self, session: zenoh.Session, service_key: str, timeout_s: float) -> None:
        self._session = session
        self._key = service_key
        self._timeout_s = timeout_s
        self._selectors: dict[str, str] = {}

    def ask(self, target: str, payload: Payload | None = None, ear: str = "") -> Answer:
        """GET, or SET, and wait for the reply.

        Raises:
            Unreachable: No reply in time, or nobody serves it.
        """
        selector = self._selectors.get(target)
        if selector is None:
            try:
                selector = selector_of(self._key, target)
            except PropertyError as error:
                return Answer(str(error), error.code)  # no key can be made of it
            if len(target) < _SHORT and len(self._selectors) < _MOST_KNOWN:
                self._selectors[target] = selector
        if ear:
            selector = for_ear(selector, ear)
        replies = self._session.get(
            selector,
            payload=payload,
            timeout=self._timeout_s,
            handler=zenoh.handlers.FifoChannel(16),
            consolidation=zenoh.ConsolidationMode.NONE,
        )
        for reply in replies:
            return answer_of(reply, self._timeout_s)
        raise Unreachable("nobody answers for it")

    @contextmanager
    def listen(self, target: str) -> Iterator[Ear]:
        """Listen to ``P`` or ``P?queue=…`` for as long as the context lasts.

        Raises:
            PropertyError: As the service answers.
        """
        name, mark, tail = target.partition("?")
        ear = Ear(self, f"{name}.listen{mark}{tail}", tail)
        key = ear_key(self._key, ear.id)
        handler = zenoh.handlers.Callback(ear.receive, indirect=False)
        subscriber = self._session.declare_subscriber(key, handler)
        try:
            ear.renew()
            yield ear
        finally:
            subscriber.undeclare()  # type: ignore[no-untyped-call]
            ear.leave()


class Ear:
    """One who listens: a bounded queue of events, the oldest goes first."""

    def __init__(self, client: PropertyClient, target: str, parameters: str) -> None:
        self.id = uuid.uuid4().hex
        self._client = client
        self._target = target
        self._events: deque[Event] = deque(maxlen=_queue_of(parameters))
        self._dropped = 0
        self._last: tuple[int, float, str] | None = None
        self._arrived = threading.Condition()
        self._renew_at = 0.0

    def receive(self, sample: zenoh.Sample) -> None:
        """Take what arrived; on a thread of the transport."""
        event = event_of(sample)
        with self._arrived:
            mark = (event.revision, event.time, event.code)
            if mark == self._last:
                return  # sent again, in case it had been lost
            self._last = mark
            if len(self._events) == self._events.maxlen:
                self._dropped += event.dropped + (self._events.maxlen > 1)
            self._events.append(event)
            self._arrived.notify()

    def renew(self) -> None:
        """Ask to be served, or to be served on.

        Raises:
            PropertyError: As the service answers.
        """
        self._client.ask(self._target, "self", self.id).value()
        self._renew_at = time.monotonic() + LEASE_S / 3

    def leave(self) -> None:
        """Ask to be served no longer; where that is not heard, the lease ends."""
        name = self._target.partition("?")[0]
        self._client.ask(f"{name}?remove", "self", self.id)

    def event(self, timeout_s: float | None = None) -> Event | None:
        """Return the next event, None if none came in time.

        Raises:
            Unreachable: The service has gone.
        """
        end = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            with self._arrived:
                now = time.monotonic()
                until = self._renew_at if end is None else min(end, self._renew_at)
                if not self._events:
                    self._arrived.wait(max(0.0, until - now))
                if self._events:
                    event, dropped = self._events.popleft(), self._dropped
                    self._dropped = 0
                    return event._replace(dropped=event.dropped + dropped) if dropped else event
            if end is not None and time.monotonic() >= end:
                return None
            self.renew()

    def __iter__(self) -> Iterator[Event]:
        while (event := self.event()) is not None:
            yield event


def _queue_of(parameters: str) -> int:
    for each in parameters.split("&"):
        key, _, value = each.partition("=")
        if key == "queue" and value.isdigit():
            return max(1, min(int(value), 10_000))
    return 1
