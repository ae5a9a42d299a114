"""Properties over zenoh: a service answers queries and sends events, a client asks and listens.

A query without payload is a GET, one with it a SET. A listener has a key of its own, subscribes to
it, and asks the service to send there; it asks again before its lease is over, and is then told the
last event once more, so that what the transport may drop under load is never the last value.

On each key events are numbered, so that what is lost on the way is counted.

Those who listen to the same in the same way are a group with one key, on which each event is sent
once. The service tells in its reply who is a member, from which number on, and the first value,
which is nobody else's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from hashlib import blake2b
from typing import NamedTuple, Protocol
from uuid import uuid4

import zenoh

from rtkit.errors import Unreachable
from rtkit.link import zenoh_keys
from rtkit.link.deadline import deadline_from_bytes
from rtkit.link.zenoh import _ERROR_ENCODING as ERROR_ENCODING
from rtkit.property.line import read_event, write_attributes
from rtkit.property.messages import Answer, Payload, PropertyEvent, text_or_bytes
from rtkit.property.naming import parse_target

_BYTES = zenoh.Encoding.APPLICATION_OCTET_STREAM
_EAR, _GROUP = "ear", "group"
_FOR_ONE = ("every", "deadband")
"""Options that depend on earlier events: a subscriber with one of them is in no group."""


class EventPosition(NamedTuple):
    """Position of an event among those that are sent on its key.

    Attributes:
        run: Since when it counts: which life of the listening, or of the group.
        number: The events that have been sent so far.
    """

    run: str
    number: int


def new_run() -> EventPosition:
    """Return where one stands who begins to send."""
    return EventPosition(uuid4().hex[:8], 0)


class EventProgress:
    """Events that a subscriber on a key of its own has received so far."""

    def __init__(self) -> None:
        self._at = EventPosition("", 0)

    def lost(self, at: EventPosition) -> int | None:
        """Return how many events were lost before this one, None if it is a repetition."""
        before = self._at.number if self._at.run == at.run else 0
        if at.number <= before:
            return None
        self._at = at
        return at.number - before - 1


class Joined(NamedTuple):
    """Message to a member that joins a group.

    Attributes:
        event: The value to begin with, or the last event; None if there is none.
        at: Up to where it need not hear the group for that.
    """

    event: PropertyEvent | None
    at: EventPosition


class Answering(Protocol):
    """Takes the answer to a query; to a member of a group, also how it stands."""

    def __call__(self, reply: Answer, joined: Joined | None = None, /) -> None:
        """See there."""
        ...


class Queried(NamedTuple):
    """Query as the service takes it.

    Attributes:
        subscription: The listener that the request is about, if it is one of `Ears`.
        group: The one that it would be in, empty if in none.
        until: When the client gives it up, by the monotonic clock of this host [s].
    """

    target: str
    payload: Payload | None
    answer: Answering
    subscription: str
    group: str = ""
    until: float = math.inf


class PropertyEndpoint:
    """Answers queries for one service on a session, and sends its events."""

    def __init__(
        self, session: zenoh.Session, service_key: str, take: Callable[[Queried], object]
    ) -> None:
        self._session = session
        self._key = service_key
        token = session.liveliness().declare_token(zenoh_keys.presence(service_key))
        self._declared: list[zenoh.Queryable[None] | zenoh.LivelinessToken] = [token]
        for mark, is_extension in (("@", False), ("@x", True)):
            prefix = f"{service_key}/{mark}/"
            receive = _receiver(prefix, is_extension, take)
            handler = zenoh.handlers.Callback(receive, indirect=False)
            self._declared.append(session.declare_queryable(prefix + "**", handler))

    def send(self, subscription: str, event: PropertyEvent, at: EventPosition) -> None:
        """Send an event to a listener, or to a group; nobody is waited for."""
        key = subscriber_key(self._key, subscription)
        encoding = _BYTES if isinstance(event.payload, bytes) else None
        attributes = _attributes(event, at)
        self._session.put(key, event.payload, attachment=attributes, encoding=encoding)

    def withdraw(self) -> None:
        """Answer nothing any more."""
        while self._declared:
            self._declared.pop().undeclare()  # type: ignore[no-untyped-call]


def _receiver(
    prefix: str, is_extension: bool, take: Callable[[Queried], object]
) -> Callable[[zenoh.Query], None]:
    def receive(query: zenoh.Query) -> None:
        key = str(query.key_expr)

        def answer(reply: Answer, joined: Joined | None = None, /) -> None:
            if joined is not None:
                event = joined.event
                payload = "" if event is None else event.payload
                encoding = _BYTES if isinstance(payload, bytes) else None
                attached = _attributes(event, joined.at)
                query.reply(key, payload, encoding=encoding, attachment=attached)
            elif reply.error:
                query.reply_err(f"{reply.error} {reply.payload!s}", encoding=ERROR_ENCODING)
            elif isinstance(reply.payload, bytes):
                query.reply(key, reply.payload, encoding=_BYTES)
            else:
                query.reply(key, reply.payload)
            query.drop()  # type: ignore[no-untyped-call]

        target = zenoh_keys.to_target(key.removeprefix(prefix), is_extension=is_extension)
        target, subscription, group = _with_parameters(target, str(query.parameters))
        attached = query.attachment
        until = math.inf if attached is None else deadline_from_bytes(attached.to_bytes())
        payload = None if query.payload is None else text_or_bytes(query.payload.to_bytes())
        take(Queried(target, payload, answer, subscription, group, until))

    return receive


def _with_parameters(target: str, parameters: str) -> tuple[str, str, str]:
    if not parameters:
        return target, "", ""
    kept, subscription, group = [], "", ""
    for each in parameters.split(";"):
        key, _, value = each.partition("=")
        if key == _EAR:
            subscription = value
        elif key == _GROUP:
            group = value
        else:
            kept.append(each)
    return (f"{target}?{'&'.join(kept)}" if kept else target), subscription, group


def selector_of(service_key: str, target: str) -> str:
    """Return what is asked for a target.

    Raises:
        PropertyError: No key can be made of it.
    """
    asked = parse_target(target)
    parameters = target.partition("?")[2].replace("&", ";")
    key = zenoh_keys.of_target(service_key, asked.name)
    return f"{key}?{parameters}" if parameters else key


def for_subscriber(selector: str, subscription: str, group: str = "") -> str:
    """Return what is asked so that it is about one listener, who would be in a group."""
    asked = f"{selector}{';' if '?' in selector else '?'}{_EAR}={subscription}"
    return f"{asked};{_GROUP}={group}" if group else asked


def subscriber_key(service_key: str, subscription: str) -> str:
    """Return the key on which events are sent to a listener, or to a group of them."""
    return f"{service_key}/@e/{subscription}"


def group_of(target: str) -> str:
    """Return the group of those who listen by a request, ``P.listen?…``; empty if in none."""
    name, _, tail = target.partition("?")
    options = sorted(each for each in tail.split("&") if each and not each.startswith("initial"))
    if any(each.partition("=")[0] in _FOR_ONE for each in options):
        return ""
    return f"g{blake2b('&'.join([name, *options]).encode(), digest_size=12).hexdigest()}"


def _attributes(event: PropertyEvent | None, at: EventPosition | None) -> str:
    place = "" if at is None else f";at={at.run}.{at.number}"
    return place if event is None else f"{write_attributes(event)}{place};name={event.name}"


def answer_of(reply: zenoh.Reply, timeout_s: float) -> Answer:
    """Return the answer that a reply carries.

    Raises:
        Unreachable: It says that there was none in time.
    """
    if reply.ok is not None:
        return Answer(text_or_bytes(reply.ok.payload.to_bytes()))
    error = reply.err
    if error is None or error.encoding != ERROR_ENCODING:
        raise Unreachable(f"no answer within {timeout_s:g} s")
    code, _, message = error.payload.to_string().partition(" ")
    return Answer(message, code)


def event_of(sample: zenoh.Sample) -> tuple[PropertyEvent | None, EventPosition | None]:
    """Return the event that a sample carries, if any, and where it stands."""
    attachment = sample.attachment
    text = "" if attachment is None else attachment.to_string()
    head, mark, name = text.partition(";name=")
    head, _, place = head.partition(";at=")
    run, _, number = place.partition(".")
    at = EventPosition(run, int(number)) if number.isdecimal() else None
    if not mark and at is not None:
        return None, at
    return read_event(name, text_or_bytes(sample.payload.to_bytes()), head), at
