"""A client of one property service over zenoh: asks, and listens alone or in a group.

Commands ask over sockets, and a proxy has a connection of its own; this is the far side that the
tests and measurements of the zenoh endpoint need.
"""

from __future__ import annotations

import contextlib
import threading
import time
import uuid
from collections import deque
from collections.abc import Callable, Iterator
from queue import Empty, SimpleQueue
from typing import Protocol

import zenoh

from rtkit.errors import RtkitError, Unreachable
from rtkit.link.deadline import deadline_to_bytes
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, Mark, Payload, PropertyEvent
from rtkit.property.subscription import LEASE_S
from rtkit.wires.zenoh.queries import (
    EventPosition,
    EventProgress,
    Joined,
    answer_of,
    event_of,
    for_subscriber,
    group_of,
    selector_of,
    subscriber_key,
)

_MOST_KEPT = 10_000


class Asking(Protocol):
    """Client that asks the service."""

    def ask_to_listen(self, target: str, subscription: str, group: str) -> Joined | None:
        """See `ZenohClient.ask_to_listen`."""
        ...


class ZenohSubscription:
    """Subscription: a bounded queue of events, the oldest goes first.

    Args:
        target: ``P.listen?…``.
        parameters: What follows the question mark.
        on_event: Takes the events, on a thread of the transport; else they wait in the queue.

    Attributes:
        id: Of its own key.
        group: In which it wants to be, empty if in none.
    """

    def __init__(
        self,
        client: Asking,
        target: str,
        parameters: str,
        on_event: Callable[[PropertyEvent], object] | None = None,
    ) -> None:
        self.id = uuid.uuid4().hex
        self.group = group_of(target)
        self._client = client
        self._on_event = on_event
        self._target = target
        self._most = _queue_of(parameters)
        self._events: SimpleQueue[PropertyEvent] = SimpleQueue()
        self._dropped = 0
        self._last: Mark | None = None
        self._lock = threading.Lock()
        self._renew_at = 0.0
        self._progress = EventProgress()
        self._at: EventPosition | None = None
        self._early: deque[tuple[PropertyEvent, EventPosition]] = deque(maxlen=self._most)
        """Events of the group that came before we know whether we are in it."""

    def receive(self, sample: zenoh.Sample) -> None:
        """Take what arrived on the key of its own; on a thread of the transport."""
        event, at = event_of(sample)
        if event is not None and at is not None:
            self.hear(event, at)

    def hear(self, event: PropertyEvent, at: EventPosition) -> None:
        """Take an event that is for nobody else."""
        with self._lock:
            lost = self._progress.lost(at)
            if lost is not None:
                self._take(event, lost)

    def follow(self, event: PropertyEvent, at: EventPosition) -> None:
        """Take what arrived for the group; on a thread of the transport."""
        with self._lock:
            if self._at is None:
                self._early.append((event, at))
            else:
                self._follow(event, at)

    def _follow(self, event: PropertyEvent, at: EventPosition) -> None:
        known = self._at
        if known is None or at.run != known.run:
            self._at = at  # the group has begun anew: nobody knows how much was missed
            self._take_once(event)
        elif at.number > known.number:
            self._at = at
            self._take(event, at.number - known.number - 1)

    def _take_once(self, event: PropertyEvent) -> None:
        """Take an event, unless it was sent again in case it had been lost."""
        if event.mark != self._last:
            self._take(event, 0)

    def _take(self, event: PropertyEvent, lost: int) -> None:
        self._last = event.mark
        if lost and self._most > 1:
            event = event._replace(dropped=event.dropped + lost)
        if self._on_event is not None:
            self._on_event(event)
            return
        if self._events.qsize() >= self._most:
            with contextlib.suppress(Empty):  # it has just been taken
                gone = self._events.get_nowait()
                self._dropped += gone.dropped + 1 if self._most > 1 else 0
        self._events.put(event)

    def renew(self) -> None:
        """Ask to be served, or to be served on.

        Raises:
            PropertyError: As the service answers.
            Unreachable: The service has gone.
        """
        joined = self._client.ask_to_listen(self._target, self.id, self.group)
        self._renew_at = time.monotonic() + LEASE_S / 3
        if joined is not None:
            with self._lock:
                self._join(joined)

    def _join(self, joined: Joined) -> None:
        if self._at is not None and joined.at.run == self._at.run:
            if joined.event is not None:
                self._follow(joined.event, joined.at)
            return
        self._at = joined.at
        if joined.event is not None:
            self._take_once(joined.event)
        for event, at in self._early:
            if at.run == joined.at.run:
                self._follow(event, at)
        self._early.clear()

    def leave(self) -> None:
        """Ask to be served no longer; if the request is lost, the lease ends."""
        name = self._target.partition("?")[0]
        with contextlib.suppress(PropertyError):  # it has ended already
            self._client.ask_to_listen(f"{name}?remove", self.id, self.group)

    def event(self, timeout_s: float | None = None) -> PropertyEvent | None:
        """Return the next event, None if none came in time.

        Raises:
            Unreachable: The service has gone.
        """
        end = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            self.renew_in_time()
            until = self._renew_at if end is None else min(end, self._renew_at)
            with contextlib.suppress(Empty):
                event = self._events.get(timeout=max(0.0, until - time.monotonic()))
                return self._counted(event) if self._dropped else event
            if end is not None and time.monotonic() >= end:
                return None

    def renew_in_time(self) -> None:
        """Ask to be served on, when it is time to."""
        now = time.monotonic()
        if now < self._renew_at:
            return
        self._renew_at = now + 1.0
        try:
            self.renew()
        except RtkitError:
            if self._events.empty():  # else events that have come are passed first
                raise

    def _counted(self, event: PropertyEvent) -> PropertyEvent:
        with self._lock:
            dropped, self._dropped = self._dropped, 0
        return event._replace(dropped=event.dropped + dropped)

    def __iter__(self) -> Iterator[PropertyEvent]:
        while (event := self.event()) is not None:
            yield event


class SharedSubscriptions:
    """Subscriptions of one session: events for a group are read once for all of them."""

    def __init__(self, session: zenoh.Session, service_key: str) -> None:
        self._session = session
        self._key = service_key
        self._lock = threading.Lock()
        self._subscriptions: dict[str, tuple[ZenohSubscription, ...]] = {}
        self._subscribers: dict[str, zenoh.Subscriber[None]] = {}

    def enter(self, subscription: ZenohSubscription) -> None:
        """Add a subscriber to its group."""
        if not subscription.group:
            return
        with self._lock:
            self._subscriptions[subscription.group] = (
                *self._subscriptions.get(subscription.group, ()),
                subscription,
            )
            if subscription.group not in self._subscribers:
                handler = zenoh.handlers.Callback(
                    self._receiver(subscription.group), indirect=False
                )
                key = subscriber_key(self._key, subscription.group)
                self._subscribers[subscription.group] = self._session.declare_subscriber(
                    key, handler
                )

    def leave(self, subscription: ZenohSubscription) -> None:
        """Remove a subscriber from its group."""
        with self._lock:
            left = tuple(
                each
                for each in self._subscriptions.get(subscription.group, ())
                if each is not subscription
            )
            if left:
                self._subscriptions[subscription.group] = left
            elif self._subscriptions.pop(subscription.group, None):
                self._subscribers.pop(subscription.group).undeclare()  # type: ignore[no-untyped-call]

    def _receiver(self, group: str) -> Callable[[zenoh.Sample], None]:
        def receive(sample: zenoh.Sample) -> None:
            event, at = event_of(sample)
            if event is not None and at is not None:
                for subscription in self._subscriptions.get(group, ()):
                    subscription.follow(event, at)

        return receive


def _queue_of(parameters: str) -> int:
    for each in parameters.split("&"):
        key, _, value = each.partition("=")
        if key == "queue" and value.isdigit():
            return max(1, min(int(value), _MOST_KEPT))
    return 1


_SHORT = 256
_MOST_KNOWN = 4096
"""Targets of which a client remembers the keys, and how long they may be."""


class ZenohClient:
    """Asks one service over a session that others may use too.

    Args:
        timeout_s: Bound on each request [s].
    """

    def __init__(self, session: zenoh.Session, service_key: str, timeout_s: float) -> None:
        self._session = session
        self._key = service_key
        self._timeout_s = timeout_s
        self._selectors: dict[str, str] = {}
        self._groups = SharedSubscriptions(session, service_key)

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
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
        return answer_of(self._reply(selector, payload), self._timeout_s)

    def ask_to_listen(self, target: str, subscription: str, group: str) -> Joined | None:
        """Serve a listener, renew it or end it; return its state in its group.

        Raises:
            PropertyError: As the service answers.
            Unreachable: No reply in time, or nobody serves it.
        """
        reply = self._reply(
            for_subscriber(selector_of(self._key, target), subscription, group), "self"
        )
        answer_of(reply, self._timeout_s).value()
        if reply.ok is None or reply.ok.attachment is None:
            return None
        event, at = event_of(reply.ok)
        return None if at is None else Joined(event, at)

    def _reply(self, selector: str, payload: Payload | None) -> zenoh.Reply:
        try:
            replies = self._session.get(
                selector,
                payload=payload,
                attachment=None if payload is None else deadline_to_bytes(self._timeout_s),
                timeout=self._timeout_s,
                handler=zenoh.handlers.FifoChannel(16),
                consolidation=zenoh.ConsolidationMode.NONE,
            )
            for reply in replies:
                return reply
        except zenoh.ZError as error:  # it was closed here
            raise Unreachable(f"the connection has ended: {error}") from error
        raise Unreachable("nobody answers for it")

    @contextlib.contextmanager
    def listen(
        self, target: str, on_event: Callable[[PropertyEvent], object] | None = None
    ) -> Iterator[ZenohSubscription]:
        """Listen to ``P`` or ``P?queue=…`` for as long as the context lasts.

        Raises:
            PropertyError: As the service answers.
        """
        name, mark, tail = target.partition("?")
        subscription = ZenohSubscription(self, f"{name}.listen{mark}{tail}", tail, on_event)
        handler = zenoh.handlers.Callback(subscription.receive, indirect=False)
        subscriber = self._session.declare_subscriber(
            subscriber_key(self._key, subscription.id), handler
        )
        self._groups.enter(subscription)
        try:
            subscription.renew()
            yield subscription
        finally:
            self._groups.leave(subscription)
            subscriber.undeclare()  # type: ignore[no-untyped-call]
            subscription.leave()
