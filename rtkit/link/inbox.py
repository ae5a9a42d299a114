"""Inbox of events that have come and were not taken: the latest of each property, or all."""

from __future__ import annotations

from collections import deque

from rtkit.property.messages import PropertyEvent


class Inbox:
    """Keeps events for a consumer that takes them one by one, however slowly."""

    def __init__(self) -> None:
        self._events: deque[PropertyEvent] = deque()
        self._latest: dict[str, PropertyEvent] = {}
        self._names_of_latest: set[str] = set()

    def expect(self, name: str, parameters: str) -> None:
        """Note how a property is listened to: without a queue only its latest event is kept."""
        is_latest = not any(each.startswith(("queue=", "mode=")) for each in parameters.split("&"))
        (self._names_of_latest.add if is_latest else self._names_of_latest.discard)(name)

    def put(self, event: PropertyEvent) -> None:
        """Keep an event."""
        if event.name in self._names_of_latest and not event.code:
            self._latest[event.name] = event
        else:
            self._events.append(event)

    def __len__(self) -> int:
        return len(self._latest) + len(self._events)

    def take(self) -> PropertyEvent | None:
        """Return the next event, None if there is none."""
        if self._latest:
            return self._latest.pop(next(iter(self._latest)))
        return self._events.popleft() if self._events else None
