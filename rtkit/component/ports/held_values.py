"""Values that an out port keeps for a connector whose other end is just being moved."""

from __future__ import annotations

from collections import deque
from threading import Condition
from time import monotonic
from typing import Generic, TypeVar

from rtkit.component.contexts.waiting import waiting
from rtkit.component.ports.buffer import Sink
from rtkit.component.ports.options import BufferOptions, FullPolicy, PortStatus

T = TypeVar("T")
HOLD_S = 30.0
"""How long values are kept for an end that does not come [s]."""


class HeldValues(Generic[T]):
    """Buffer of the policy of the in port, until that is there again; then it passes values on."""

    def __init__(self, options: BufferOptions) -> None:
        self._options = options
        self._items: deque[T] = deque()
        self._changed = Condition()
        self._sink: Sink[T] | None = None
        self._until = monotonic() + HOLD_S

    def write(self, value: T) -> PortStatus | None:
        """Take a value, as the in port would: drop, refuse or wait where it is full."""
        with self._changed:
            if self._sink is None and monotonic() > self._until:
                self._items.clear()
                return PortStatus.CONNECTION_LOST
            if self._sink is None and len(self._items) >= self._options.length:
                refused = self._make_room()
                if refused is not None:
                    return refused
            if self._sink is not None:
                return self._sink(value)
            self._items.append(value)
            return None

    def resume(self, sink: Sink[T]) -> None:
        """Pass on what was kept, then what a writer still brings."""
        with self._changed:
            while self._items and monotonic() <= self._until:
                sink(self._items.popleft())
            self._sink = sink
            self._changed.notify_all()

    def _make_room(self) -> PortStatus | None:
        policy = self._options.full_policy
        if policy is FullPolicy.OVERWRITE:
            self._items.popleft()
            return None
        if policy is FullPolicy.DO_NOTHING:
            return PortStatus.FULL
        with waiting(self._options.write_timeout):
            is_back = self._changed.wait_for(
                lambda: self._sink is not None, self._options.write_timeout
            )
        return None if is_back else PortStatus.TIMEOUT
