"""``rtls --watch`` of a property service: subscribes to the names and values on show."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import ExitStack

from rtkit.cli.properties.asking import connected
from rtkit.cli.shared import terminal
from rtkit.cli.shared.signals import resizing
from rtkit.cli.shared.stdout_reader import wait_for
from rtkit.cli.shared.watch import WatchedScreen
from rtkit.cli.tree.service_listing import ServiceListing
from rtkit.property.codes import PropertyError
from rtkit.tree.property_subscription import PropertySubscription

_MOST = 1000
"""Number of properties that one connection subscribes to; services bound it."""


def watch_service(listing: ServiceListing, sight: WatchedScreen) -> None:
    """Show a listing again when something of it has changed, until nobody reads it.

    Raises:
        PropertyError: The service has gone.
    """
    with (
        _ServiceSubscriptions(listing) as subscriptions,
        resizing(terminal.is_terminal()) as wakeup,
    ):
        while True:
            if wakeup.take():
                sight.forget()
            if subscriptions.has_changes():
                sight.stale()
            if sight.is_due:
                sight.show(listing.look)
                subscriptions.listen_to(listing.names)
            wait_for([wakeup.fileno(), *subscriptions.sources], sight.due())


class _ServiceSubscriptions:
    """Subscriptions to the names below a place, and to the values of those shown."""

    def __init__(self, listing: ServiceListing) -> None:
        self._listing = listing
        self._open = ExitStack()
        self._subscriptions: list[PropertySubscription] = []
        self._known: set[str] = set()

    def __enter__(self) -> _ServiceSubscriptions:
        self._subscribe([self._listing.place.typed], ["mode=diff"] if self._listing.is_deep else [])
        return self

    def __exit__(self, *raised: object) -> None:
        self._open.close()

    @property
    def sources(self) -> Iterable[int]:
        """Descriptors, one of which is readable when there is a change."""
        return [subscription.fileno() for subscription in self._subscriptions]

    def has_changes(self) -> bool:
        """Take all changes, and return whether there were any.

        Raises:
            PropertyError: The service has gone.
        """
        taken = False
        for subscription in self._subscriptions:
            while subscription.take() is not None:
                taken = True
        return taken

    def listen_to(self, names: Sequence[str]) -> None:
        """Subscribe to the values of properties, unless that is done already."""
        new = [name for name in names if name not in self._known]
        self._known = set(names)
        place = self._listing.place.typed.rstrip("/")
        for first in range(0, len(new), _MOST):
            try:
                self._subscribe([f"{place}.{name}" for name in new[first : first + _MOST]], [])
            except PropertyError as error:
                if error.code != "unknown":
                    raise
                # A property has gone meanwhile; the subscription to names reports that.
                self._known.clear()

    def _subscribe(self, targets: Sequence[str], parameters: Sequence[str]) -> None:
        places = self._open.enter_context(connected(self._listing.app, None))
        self._subscriptions.append(
            self._open.enter_context(PropertySubscription(places, targets, "&".join(parameters)))
        )
