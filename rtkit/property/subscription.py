"""Queue between a property and one listener.

By default it holds the latest value only. Nothing here knows of clocks or connections: time comes
in as an argument [s, of a clock that never goes back]. Source: `property-service` reference,
section 6.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple, Protocol

from rtkit.property.codes import PropertyError
from rtkit.property.messages import PropertyEvent
from rtkit.property.naming import with_parameter
from rtkit.property.values import Value, is_number, is_vector

LONGEST_QUEUE = 10_000
LONGEST_LEASE_S = 86_400.0
LEASE_S = 10.0
"""Lease of a listener that may go without a word, unless it asks for another [s]."""


class SubscriptionOptions(NamedTuple):
    """Options of a subscription.

    Attributes:
        queue: Events that are kept while they cannot be sent; the oldest goes first.
        every_s: Least time between two events [s].
        deadband: Least change of a number, or of any in a vector.
        is_all: Each SET is an event, not only each change.
        has_initial: The present value is the first event.
        lease_s: How long to listen unless asked again [s]; for ever when it is zero.
        is_difference: Of a list of names only what came and went.
    """

    queue: int = 1
    every_s: float = 0.0
    deadband: float = 0.0
    is_all: bool = False
    has_initial: bool = True
    lease_s: float = 0.0
    is_difference: bool = False


class EventReceiver(Protocol):
    """Requester as a listener knows it: the receiver of its events."""

    identity: str

    def wake(self) -> None:
        """Note that a listener of it has something to send."""

    def unlisten(self, listener: Listener) -> None:
        """Forget a listener that has ended."""


class Listener:
    """Subscription to one property, or to a part of it."""

    __slots__ = (
        "_at", "_baseline", "_dropped", "_events", "_offered", "caller", "ends_at", "has_ended",
        "name", "options", "path",
    )  # fmt: skip

    def __init__(
        self, name: str, path: tuple[str, ...], options: SubscriptionOptions, caller: EventReceiver
    ) -> None:
        self.name = name
        self.path = path
        self.options = options
        self.caller = caller
        self.ends_at: float | None = None
        self.has_ended = False
        self._events: deque[PropertyEvent] = deque()
        self._dropped = 0
        self._at = float("-inf")
        self._offered: object = None
        self._baseline: object = None

    def renew(self, now: float) -> None:
        """Begin the lease anew."""
        self.ends_at = now + self.options.lease_s if self.options.lease_s else None

    def offer(self, event: PropertyEvent, value: object, *, is_first: bool = False) -> bool:
        """Queue an event if it is one for this listener; return whether it is."""
        options = self.options
        if not is_first and not options.is_all:
            if event.payload == self._offered and not event.code:
                return False
            if options.deadband and not event.code and self._is_within(value):
                return False
        self._offered, self._baseline = event.payload, value
        if is_first and not options.has_initial:
            return False
        self.push(event)
        return True

    def push(self, event: PropertyEvent) -> None:
        """Queue an event; a full queue drops its oldest, and all that this one counted."""
        if len(self._events) >= self.options.queue:
            self._dropped += 1 + self._events.popleft().dropped
        self._events.append(event)

    def _is_within(self, value: object) -> bool:
        """Return whether numbers differ by less than the deadband from those last sent."""
        before = self._baseline
        pairs: list[tuple[Value, Value]] = []
        if is_number(value) and is_number(before):
            pairs = [(value, before)]  # type: ignore[list-item]
        elif is_vector(value) and is_vector(before) and len(value) == len(before):  # type: ignore[arg-type]
            pairs = list(zip(value, before, strict=True))  # type: ignore[call-overload]
        return bool(pairs) and all(
            abs(new - old) < self.options.deadband  # type: ignore[operator]
            for new, old in pairs
        )

    def take(self, now: float) -> PropertyEvent | None:
        """Return the next event that is to be sent now, with the count of those left out."""
        if not self._events or now < self._at + self.options.every_s:
            return None
        self._at = now
        event = self._events.popleft()
        if self._dropped and self.options.queue > 1:
            event = event._replace(dropped=event.dropped + self._dropped)
        self._dropped = 0
        return event

    def due(self) -> float | None:
        """Return when there is something to send or to end, None when nothing is to come."""
        times = [self._at + self.options.every_s] if self._events else []
        if self.ends_at is not None:
            times.append(self.ends_at)
        return min(times, default=None)

    @property
    def pending(self) -> int:
        """Return how many events wait."""
        return len(self._events)


def listen_target(name: str, options: str) -> str:
    """Return the target of a request to listen; without a name it is about all names."""
    return f"{name}.listen".lstrip(".") + (f"?{options}" if options else "")


def leased(target: str, lease_s: float = LEASE_S) -> str:
    """Return a request to listen with a lease [s], unless it has one or ends a listening."""
    given = target.partition("?")[2].split("&")
    is_leased = any(each.startswith(("lease=", "remove")) for each in given)
    return target if is_leased else with_parameter(target, f"lease={lease_s:g}")


def options_of(parameters: dict[str, Value]) -> SubscriptionOptions:
    """Read the options of a subscription from the parameters of the request.

    Raises:
        PropertyError: ``bad-parameter``.
    """
    given = dict(parameters)
    queue = _number(given, "queue", 1)
    if queue != int(queue) or not 1 <= queue <= LONGEST_QUEUE:
        raise PropertyError("bad-parameter", f"queue is 1 to {LONGEST_QUEUE}")
    lease = _number(given, "lease", 0)
    if lease > LONGEST_LEASE_S:
        raise PropertyError("bad-parameter", f"lease is at most {LONGEST_LEASE_S:g} s")
    mode = str(given.pop("mode", "change"))
    if mode not in ("change", "all", "diff"):
        raise PropertyError("bad-parameter", "mode is change, all or diff")
    initial = given.pop("initial", True)
    options = SubscriptionOptions(
        int(queue),
        _number(given, "every", 0),
        _number(given, "deadband", 0),
        mode == "all",
        initial not in (0, False),
        lease,
        mode == "diff",
    )
    if given:
        raise PropertyError("bad-parameter", f"not a parameter of listen: {min(given)}")
    return options


def _number(given: dict[str, Value], key: str, default: float) -> float:
    value = given.pop(key, default)
    if not is_number(value) or not 0 <= value < float("inf"):  # type: ignore[operator]
        raise PropertyError("bad-parameter", f"{key} is a number that is not negative")
    return value  # type: ignore[return-value]
