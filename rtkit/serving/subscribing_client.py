"""Client of an endpoint that may listen there, as much as the quota allows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.property.requests import Requester
from rtkit.property.subscription import Listener

if TYPE_CHECKING:
    from rtkit.serving.quota import EndpointQuota


class SubscribingClient(Requester):
    """Requester with listeners.

    Args:
        room: How much there is room for, and what may be done.
    """

    def __init__(self, quota: EndpointQuota, identity: str = "") -> None:
        super().__init__(identity)
        self.access = quota.access
        self._quota = quota
        self._listeners: list[Listener] = []

    @property
    def listening(self) -> int:
        """Return how many subscriptions it has."""
        return len(self._listeners)

    @property
    def has_pending(self) -> bool:
        """Return whether an event waits to be sent."""
        return any(each.pending for each in self._listeners)

    def listen(self, listener: Listener) -> None:
        """See `Requester.listen`."""
        self._quota.check_listeners(self.listening)
        self._listeners.append(listener)

    def unlisten(self, listener: Listener) -> None:
        """See `Requester.unlisten`."""
        if listener in self._listeners:
            self._listeners.remove(listener)
