"""Subscribers through a transport that keeps no connection: single ones, and groups of equals.

The queue is here; what is sent is not waited for.
"""

from __future__ import annotations

from time import monotonic
from typing import Protocol

from rtkit.property.messages import PropertyEvent
from rtkit.property.requests import ListeningRequester
from rtkit.property.subscription import Listener
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop
from rtkit.serving.quota import EndpointQuota, SubscribingClient
from rtkit.wires.zenoh.queries import EventPosition, Joined, new_run


class EventSender(Protocol):
    """Server through which subscribers send.

    Attributes:
        quota: Of its endpoint.
    """

    quota: EndpointQuota

    def has_room(self) -> bool:
        """Return whether an event can be sent now."""

    def send(self, id: str, event: PropertyEvent, at: EventPosition) -> None:
        """Send an event to a subscriber, or to a group of them."""


class Subscriber(IOHandler, SubscribingClient):
    """Single subscriber, on a key of its own.

    Attributes:
        asked: How many requests to listen are not answered yet.
    """

    def __init__(
        self, sender: EventSender, host: PropertyEventLoop, id: str, identity: str
    ) -> None:
        super().__init__(sender.quota, identity)
        self._sender = sender
        self._host = host
        self._id = id
        self.asked = 0
        self._last: PropertyEvent | None = None
        self._at = new_run()

    @property
    def is_used(self) -> bool:
        """Return whether it listens to anything, or is about to."""
        return bool(self.listeners or self.asked)

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`."""
        return self.send_due(now, self._sender.has_room, self._send)

    def _send(self, listener: Listener, event: PropertyEvent) -> None:
        self._last = event
        self._at = EventPosition(self._at.run, self._at.number + 1)
        self._sender.send(self._id, event, self._at)

    def repeat(self) -> None:
        """Send the last event once more: it may have been lost."""
        if self._last is not None and not self.has_pending:
            self._sender.send(self._id, self._last, self._at)

    def first(self) -> PropertyEvent | None:
        """Take the value that it begins with, before anything was sent."""
        now = monotonic()
        return next((event for each in self.listeners if (event := each.take(now))), None)


class SharedSubscription(Subscriber):
    """Group of subscribers with equal options: one listener, each event is sent once.

    Whoever is slow or gone holds up nobody: the queues are with the members. Each has a lease.
    """

    def __init__(
        self, sender: EventSender, host: PropertyEventLoop, id: str, identity: str
    ) -> None:
        super().__init__(sender, host, id, identity)
        self._until: dict[str, float] = {}

    @property
    def listening(self) -> int:
        """Return how many members there are."""
        now = monotonic()
        for gone in [id for id, until in self._until.items() if until < now]:
            del self._until[gone]
        return len(self._until) if self.listeners else 0

    def listen(self, listener: Listener) -> None:
        """See `Requester.listen`: the quota was checked before."""
        ListeningRequester.listen(self, listener)

    def has_member(self, id: str) -> bool:
        """Return whether a subscriber is a member."""
        return self.is_used and id in self._until

    def enter(self, id: str) -> EventPosition:
        """Add a member; return the position up to which it has the events."""
        lease_s = max((each.options.lease_s for each in self.listeners), default=0.0)
        self._until[id] = monotonic() + lease_s if lease_s else float("inf")
        return self._at

    def renew(self, id: str) -> Joined:
        """Renew a member; return the position of the group."""
        return Joined(self._last, self.enter(id))

    def leave(self, id: str) -> None:
        """Remove a member."""
        self._until.pop(id, None)
