"""Messages between an endpoint and a service: requests, answers, events, and the requester."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, NamedTuple

from rtkit.guard import kind_and_text, text_of
from rtkit.property.access import Access
from rtkit.property.codes import code_of, rebuilt

if TYPE_CHECKING:
    from rtkit.property.subscription import Listener

Payload = str | bytes
"""Characters end to end; bytes only of properties that are declared so."""

Mark = tuple[int, float, str, str, Payload]


class Answer(NamedTuple):
    """Outcome of one request: the value, or the code and text of an error."""

    payload: Payload
    error: str = ""

    def value(self) -> Payload:
        """Return the value.

        Raises:
            RtkitError: The service answered with an error.
        """
        if self.error:
            raise rebuilt(self.error, str(self.payload))
        return self.payload


DONE = Answer("")


def failed(error: BaseException) -> Answer:
    """Return the answer that stands for an error; no trace, no class of ours in it."""
    code = code_of(error)
    return Answer(kind_and_text(error) if code == "internal" else text_of(error), code)


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
        from rtkit.property.codes import PropertyError

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


class PropertyEvent(NamedTuple):
    """Change of a property as a listener receives it.

    Attributes:
        time: When the value came into force [s since 1970].
        quality: ``good``, ``uncertain``, ``bad`` or ``stale``.
        dropped: How many events before this one were not sent.
        code: Why no further one will come; empty while it lives.
    """

    name: str
    payload: Payload
    time: float
    revision: int
    quality: str = "good"
    dropped: int = 0
    code: str = ""

    @property
    def mark(self) -> Mark:
        """Return the mark that an event shares with a repetition of it."""
        return self.revision, self.time, self.quality, self.code, self.payload
