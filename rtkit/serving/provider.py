"""Interface of a service for endpoints and the loop: it owns properties, or stands for an owner."""

from __future__ import annotations

from typing import Protocol

from rtkit.property.requests import PropertyRequest, Requester


class PropertyProvider(Protocol):
    """Answers requests and sends changes; callers hold the lock of the host.

    By default nothing is known of its properties but what their owner answers.

    Attributes:
        name: Under which it is found.
        has_groups: Those who listen in the same way may share one listener.
    """

    name: str
    has_groups: bool

    @property
    def is_polled(self) -> bool:
        """Return whether something that is listened to is to be read anew from time to time."""
        return False

    def quick(self, line: bytes, caller: Requester) -> bytes | None:
        """Return the reply to a request line, None unless it takes only a look."""
        return None

    def is_plain(self, name: str) -> bool:
        """Return whether nothing of the user's is called when a property is got or set."""
        return False

    def is_text(self, name: str) -> bool:
        """Return whether a property is known to hold text that is no value."""
        return False

    def revision(self, name: str) -> int | None:
        """Return the revision of a property, None if it is not known here."""
        return None

    def handle(self, ask: PropertyRequest) -> None:
        """Answer a request, now or later; never raises for what is asked."""

    def forget(self, caller: Requester) -> None:
        """Send nothing any more to who is gone."""

    def poll(self) -> None:
        """Read anew what is to be."""
        return

    def tick(self) -> None:
        """End the leases that are over."""
