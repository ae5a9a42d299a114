"""Requests to a service, and the requester that sends them through an endpoint."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, NamedTuple

from rtkit.property.access import Access
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, Payload

if TYPE_CHECKING:
    from rtkit.property.subscription import Listener


class Requester:
    """Sender of requests through an endpoint, as far as a service knows it.

    Attributes:
        identity: A name that the endpoint has made sure of; empty for anybody.
        origin: Whose requests, repeated with their id, are the same ones.
        access: What the endpoint lets whom do.
    """

    access = Access()

    def __init__(self, identity: str = "") -> None:
        self.identity = identity
        self.origin: Hashable = self

    def may(self, method: str, name: str) -> bool:
        """Return whether it may GET or SET a property, or what is asked about it."""
        return self.access.may(self.identity, method, name)

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


OWNER = Requester("owner")
"""The process that owns the service."""


class PropertyRequest(NamedTuple):
    """GET (no payload) or SET of a property.

    Attributes:
        target: As it was asked for, service cut off.
        answer: To be called exactly once.
        id: By which a repetition of the same request of this caller is known.
        until: When nobody waits for the answer any more [s], by the clock of the service.
    """

    target: str
    payload: Payload | None
    answer: Callable[[Answer], object]
    caller: Requester = OWNER
    id: str = ""
    until: float = math.inf
