"""Property subscription: events of several properties, of several owners, in order of arrival."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Sequence

from rtkit.closing import Closing
from rtkit.errors import RtkitError
from rtkit.link.wakeup import Wakeup
from rtkit.property.messages import PropertyEvent
from rtkit.tree.property_connections import PropertyConnections, printed_error, with_near_names
from rtkit.wires.property_client import PropertyClient

_Received = tuple[str, PropertyEvent | Exception]


class PropertySubscription(Closing):
    """Listens to all targets; refused when one of them is.

    Its descriptor is readable when there is something to `take`.

    Raises:
        PropertyError: As commands show it.
    """

    def __init__(
        self, places: PropertyConnections, targets: Sequence[str], parameters: str
    ) -> None:
        self._come: deque[_Received] = deque()
        self._wakeup = Wakeup()
        names: dict[int, dict[str, str]] = {}
        ends: dict[int, PropertyClient] = {}
        try:
            for typed in targets:
                place, end = places.find(typed)
                target = place.target(parameters)
                try:
                    end.listen(target)
                except RtkitError as error:
                    raise with_near_names(error, place, end) from error
                name = target.partition("?")[0]
                names.setdefault(id(end), {})[name] = typed
                ends[id(end)] = end
        except BaseException:
            self.close()
            raise
        for key, end in ends.items():
            arguments = (end, names[key], targets[0])
            threading.Thread(target=self._receive, args=arguments, daemon=True).start()

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._wakeup.fileno()

    def _receive(self, end: PropertyClient, names: dict[str, str], first: str) -> None:
        try:
            while (event := end.event()) is not None:
                self._note(names.get(event.name, event.name), event)
        except RtkitError as error:
            self._note(next(iter(names.values()), first), error)

    def _note(self, typed: str, received: PropertyEvent | Exception) -> None:
        self._come.append((typed, received))
        self._wakeup.ring()

    def take(self) -> tuple[str, PropertyEvent] | None:
        """Return the next event with the target as it was typed, None if there is none now.

        Raises:
            PropertyError: An owner has gone.
        """
        if not self._come:
            self._wakeup.hush()
        # A change between the two has rung again.
        if not self._come:
            return None
        typed, received = self._come.popleft()
        if isinstance(received, Exception):
            raise printed_error(typed, received) from received
        return typed, received

    def close(self) -> None:
        """Take no more."""
        self._wakeup.close()
