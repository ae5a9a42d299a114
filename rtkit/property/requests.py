"""Requests to a service, and the requester that sends them through an endpoint."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from contextvars import ContextVar
from typing import TYPE_CHECKING, NamedTuple

from rtkit.property.access import Access
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.property.naming import without_parameter

if TYPE_CHECKING:
    from rtkit.property.subscription import Listener


class Requester:
    """Sender of requests through an endpoint, as far as a service knows it.

    Attributes:
        identity: A name that the endpoint has made sure of; empty for anybody.
        origin: Whose requests, repeated with their id, are the same ones.
        access: Access rules of the endpoint.
    """

    access = Access()

    def __init__(self, identity: str = "") -> None:
        self.identity = identity
        self.origin: Hashable = self

    def may(self, method: str, name: str) -> bool:
        """Return whether it may GET or SET a property, or what is asked about it."""
        return self.access.may(self.identity, method, name)

    def audited(self, ask: PropertyRequest, service: str) -> PropertyRequest:
        """Return a request to a service, so that it is on record where the endpoint keeps one."""
        return ask

    def listen(self, listener: Listener) -> None:
        """Take on what is to be sent to this caller.

        Raises:
            PropertyError: ``denied``: the endpoint cannot carry events, or it has enough listeners.
        """
        raise PropertyError("denied", "no events on this connection")

    def unlisten(self, listener: Listener) -> None:
        """Forget a listener that has ended."""

    def wake(self) -> None:
        """Note that a listener of it has something to send."""


class ListeningRequester(Requester):
    """Requester that keeps its listeners, and sends their events when they are due."""

    def __init__(self, identity: str = "") -> None:
        super().__init__(identity)
        self.listeners: list[Listener] = []

    @property
    def listening(self) -> int:
        """Return how many subscriptions it has."""
        return len(self.listeners)

    @property
    def has_pending(self) -> bool:
        """Return whether an event waits to be sent."""
        return any(each.pending for each in self.listeners)

    def listen(self, listener: Listener) -> None:
        """See `Requester.listen`."""
        self.listeners.append(listener)

    def unlisten(self, listener: Listener) -> None:
        """See `Requester.unlisten`."""
        if listener in self.listeners:
            self.listeners.remove(listener)

    def send_due(
        self,
        now: float,
        has_room: Callable[[], bool],
        send: Callable[[Listener, PropertyEvent], object],
    ) -> float | None:
        """Send the events that are due while there is room; return when others will be [s]."""
        due: list[float] = []
        for listener in list(self.listeners):
            while listener.pending and has_room() and (event := listener.take(now)) is not None:
                send(listener, event)
            if not listener.pending:
                if listener.has_ended:
                    self.listeners.remove(listener)
            elif has_room() and (at := listener.due()) is not None:
                due.append(at)
        return min(due) if due else None


OWNER = Requester("owner")
"""The process that owns the service."""


class PropertyRequest(NamedTuple):
    """GET (no payload) or SET of a property.

    Attributes:
        target: As it was asked for, service cut off.
        answer: To be called exactly once.
        id: By which a repetition of the same request of this caller is known.
        until: When nobody waits for the answer any more [s], by the clock of the service.
        via: Ids of the services that passed it on, so that none does so twice.
    """

    target: str
    payload: Payload | None
    answer: Callable[[Answer], object]
    caller: Requester = OWNER
    id: str = ""
    until: float = math.inf
    via: tuple[str, ...] = ()


class UnderWay(NamedTuple):
    """Request that user code answers, for those that it makes to do so.

    Attributes:
        via: Ids of those who ask in turn, and wait for the answer.
        until: When nobody does any more [s], by the monotonic clock.
    """

    via: tuple[str, ...] = ()
    until: float = math.inf

    def call(self, work: Callable[[], object]) -> None:
        """Do something that answers it."""
        token = UNDER_WAY.set(self)
        try:
            work()
        finally:
            UNDER_WAY.reset(token)


UNDER_WAY = ContextVar("UNDER_WAY", default=UnderWay())  # noqa: B039  it does not change

PASSES_ON = "~proxy.passes"
"""Property by which an owner that knows `via` tells whether it passes requests on: 0, or 1."""
VIA = "_via"


def is_among_proxies(target: str) -> bool:
    """Return whether a target may hold what only proxies tell each other; most do not."""
    return f"{VIA}=" in target or target.endswith(PASSES_ON)


def split_via(ask: PropertyRequest) -> PropertyRequest:
    """Return a request as it was asked first, with who has passed it on."""
    given = ask.target.partition("?")[2].split("&")
    ways = [each.partition("=")[2] for each in given if each.startswith(f"{VIA}=")]
    if not ways:
        return ask
    via = tuple(each for way in ways for each in way.split(".") if each)
    return ask._replace(target=without_parameter(ask.target, VIA), via=via)
