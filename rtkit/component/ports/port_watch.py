"""Notes the last value of a port, for as long as somebody looks at it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from threading import Lock
from time import monotonic
from typing import Any, Generic, TypeVar

from rtkit.component.ports.buffer import AnyRing, Ring, Sink
from rtkit.component.ports.options import PortStatus

T = TypeVar("T")
WATCHED_S = 3.0
"""How long a port is watched after the last look at it [s]."""


class Watchable(ABC, Generic[T]):
    """Base of ports that can be watched."""

    _lock: Lock
    _watch: PortWatch[T] | None = None

    def watch(self) -> PortWatch[T]:
        """Have values noted from now on, and return the notes; ends when not asked for again."""
        with self._lock:
            if self._watch is None:
                self._watch = PortWatch(self._unwatch)
                self._rewire()
            self._watch.renew()
            return self._watch

    def _unwatch(self, watch: PortWatch[T]) -> None:
        with self._lock:
            if self._watch is watch and watch.is_over:
                self._watch = None
                self._rewire()

    @abstractmethod
    def _rewire(self) -> None:
        """Have values pass by the watch, or no longer; under the lock."""


class PortWatch(Generic[T]):
    """Notes of one port; a port that nobody looks at has none, and pays nothing.

    A writer that changes a list after it has written it may show the change.

    Attributes:
        last: When the last value came, monotonic [s], and the value; None until one comes.
        dropped: How many values a full buffer has dropped since the watch began, by connector.
        shown: What the last value is shown as, kept for the next look.
    """

    def __init__(self, end: Callable[[PortWatch[T]], object]) -> None:
        """Begin; `end` is called by the first value that comes when nobody looks any more."""
        self._end = end
        self._until = 0.0
        self.last: tuple[float, T] | None = None
        self.dropped: dict[str, int] = {}
        self.shown: tuple[object, Any] | None = None
        self.renew()

    def renew(self) -> None:
        """Go on: somebody looks."""
        self._until = monotonic() + WATCHED_S

    @property
    def is_over(self) -> bool:
        """Return whether nobody has looked for a while."""
        return monotonic() > self._until

    def note(self, value: T) -> None:
        """Note a value, on the thread that brings it."""
        now = monotonic()
        self.last = (now, value)
        if now > self._until:
            self._end(self)

    def noting(self, connector_id: str, ring: AnyRing[T]) -> Sink[T]:
        """Return a sink that notes values and their loss on the way into a buffer."""
        write, note = ring.write, self.note
        if not isinstance(ring, Ring):  # these count their losses themselves

            def write_noted(value: T) -> PortStatus | None:
                note(value)
                return write(value)

            return write_noted
        length = ring.length
        self.dropped[connector_id] = 0

        def write_counted(value: T) -> PortStatus | None:
            if len(ring) >= length:
                self.dropped[connector_id] += 1
            note(value)
            return write(value)

        return write_counted
