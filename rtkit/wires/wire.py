"""Interface of the clients of all wires."""

from __future__ import annotations

import math
from typing import Protocol

from rtkit.property.messages import Answer, Payload, PropertyEvent


class PropertyClient(Protocol):
    """A connection to the owner of properties."""

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
        """GET, or SET."""
        ...

    def listen(self, target: str) -> None:
        """Begin to listen."""
        ...

    def event(self, timeout_s: float | None = None) -> PropertyEvent | None:
        """Return the next event, None if none came in time."""
        ...

    def close(self) -> None:
        """End the connection."""
        ...


class BoundedClient(PropertyClient, Protocol):
    """A connection on which each request may be given up sooner."""

    def ask(self, target: str, payload: Payload | None = None, until: float = math.inf) -> Answer:
        """GET, or SET that has begun at `until`, by the monotonic clock [s], or never does."""
        ...
