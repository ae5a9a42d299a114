"""Interface of a connection to the owner that a proxy stands for, and of its maker."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from rtkit.property.codes import PASSING
from rtkit.property.messages import Answer, Payload, PropertyEvent

Answering = Callable[[Answer], object]
Hearing = Callable[[PropertyEvent], object]
Gone = Callable[[str], object]

STATUS = "~proxy.status"
"""Property that every proxy answers itself; asked of a silent peer, to learn that it lives."""


class ProviderConnection(Protocol):
    """Connection to an owner, used by the loop only; its callbacks run there."""

    def start(self, gone: Gone) -> None:
        """Start the connection; `gone` is called once with the reason when it ends."""
        ...

    def ask(
        self,
        target: str,
        payload: Payload | None,
        id: str,
        answer: Answering,
        until: float = math.inf,
    ) -> None:
        """GET, or SET; `answer` is called exactly once, also when the connection ends.

        What is asked one after the other arrives in that order. By the id, one of
        `rtkit.property.idempotency.shared`, a repetition is known; it is empty for nothing. What
        has not begun at `until`, by the monotonic clock of this host [s], is to be done by nobody.
        """
        ...

    def has_room(self, name: str) -> bool:
        """Return whether it can listen to this beside what it listens to."""
        ...

    def listen(self, name: str, options: str, hear: Hearing, answer: Answering) -> None:
        """Listen to a property, with the parameters `options`."""
        ...

    def leave(self, name: str) -> None:
        """Listen to a property no longer."""
        ...

    def check(self, now: float) -> None:
        """Check whether the peer has been silent for too long [s, of a monotonic clock]."""
        ...

    def close(self) -> None:
        """Close the connection; callers that wait for an answer get an error."""
        ...


Wire = Callable[[], ProviderConnection]
"""Makes a connection. It may take its time, on a thread of its own, and raises `RtkitError`."""


def with_id(target: str, id: str) -> str:
    """Return a target with an id among its parameters, for wires that have no other place."""
    return f"{target}{'&' if '?' in target else '?'}id={id}" if id else target


def over(name: str, reply: Answer) -> PropertyEvent | None:
    """Return the last event of a listening that the owner does not go on with, None if it may."""
    if not reply.error or reply.error in PASSING:
        return None
    return PropertyEvent(name, "", 0.0, 0, "bad", 0, reply.error)


def slot(name: str) -> str:
    """Return the name in events of a property: an inner name has events of its listing."""
    return "" if name == "properties" else name.removesuffix(".properties")
