"""Client of a wire: its interface, and the inbox of its events."""

from __future__ import annotations

import math
from collections import deque
from typing import Protocol

from rtkit.errors import Unreachable
from rtkit.property.codes import code_of
from rtkit.property.messages import Answer, Payload, PropertyEvent

_GRACE_S = 0.1


class PropertyClient(Protocol):
    """A connection to the owner of properties."""

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
        """GET, or SET, and wait for the reply: as long as ``timeout=`` says, and a little more.

        Raises:
            Unreachable: No reply in time, or the connection has ended.
        """

    def listen(self, target: str) -> None:
        """Begin to listen to ``P`` or ``P?queue=…``.

        Without a queue only the latest event is kept, however slowly they are taken.

        Raises:
            PropertyError: As the service answers.
            Unreachable: No reply in time, or the connection has ended.
        """

    def event(self, timeout_s: float | None = None) -> PropertyEvent | None:
        """Return the next event, None if none came in time; without a bound it waits for ever.

        Raises:
            Unreachable: A connection has ended.
        """

    def close(self) -> None:
        """End the connection."""


class BoundedClient(PropertyClient, Protocol):
    """A connection on which each request may be given up sooner."""

    def ask(self, target: str, payload: Payload | None = None, until: float = math.inf) -> Answer:
        """See `PropertyClient.ask`; it ends at `until`, by the monotonic clock here [s], too.

        A SET that has not begun by then never does.
        """


def bound_in(target: str, timeout_s: float) -> float:
    """Return how long a request is waited for [s]: as its target states, and not above a bound.

    A little more than is stated, as the service answers at that moment, and knows better why.
    """
    if "timeout=" not in target:
        return timeout_s
    from rtkit.property.lanes import timeout_in

    return min(timeout_s, max(0.0, timeout_in(target)) + _GRACE_S)


def failure(error: Exception) -> Answer:
    """Return the answer that stands for a call that failed."""
    is_late = isinstance(error, Unreachable) and str(error).startswith("no answer within")
    code = "timeout" if is_late else code_of(error)
    return Answer(str(error).removeprefix(f"{code}: "), code)


class Inbox:
    """Keeps events for a consumer that takes them one by one, however slowly."""

    def __init__(self) -> None:
        self._events: deque[PropertyEvent] = deque()
        self._latest: dict[str, PropertyEvent] = {}
        self._names_of_latest: set[str] = set()
        self._paths: dict[str, str] = {}

    def expect(self, name: str, parameters: str) -> None:
        """Note how a property is listened to: without a queue only its latest event is kept.

        Events come under the name without its service: of two services that have it, all are kept.
        """
        path, name = name, name.rpartition("/")[2]
        is_alone = self._paths.setdefault(name, path) == path
        has_queue = any(each.startswith(("queue=", "mode=")) for each in parameters.split("&"))
        is_latest = is_alone and not has_queue
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
