"""Bound of the values that have arrived for a tool and that it has not dealt with."""

from __future__ import annotations

from collections.abc import Iterable
from threading import Condition

from rtkit.link.local.channel import MOST_INLINE

_MOST_BYTES = 8 << 20
_MOST_LARGE = 6
"""How many large values may wait. As many are in the hands of the tool, and all together are fewer
than a reader may keep in the memory of their writer."""
_PATIENCE_S = 60.0


class Backlog:
    """Values that wait for a tool: few, so that who writes waits, and not the memory fills.

    Beyond a number large ones would be copied, too, out of the memory that they arrive in.
    """

    def __init__(self) -> None:
        self._changed = Condition()
        self._cost = 0
        self._is_open = False

    def enter(self, payload: bytes) -> None:
        """Wait until there is room for a value, a minute at most, and count it."""
        cost = _cost(payload)
        with self._changed:
            self._changed.wait_for(lambda: self._has_room(cost), _PATIENCE_S)
            self._cost += cost

    def _has_room(self, cost: int) -> bool:
        return self._is_open or not self._cost or self._cost + cost <= _MOST_BYTES

    def leave(self, payloads: Iterable[bytes]) -> None:
        """Count values no more."""
        with self._changed:
            self._cost -= sum(map(_cost, payloads))
            self._changed.notify_all()

    def open(self) -> None:
        """Let all values in from now on."""
        with self._changed:
            self._is_open = True
            self._changed.notify_all()


def _cost(payload: bytes) -> int:
    size = len(payload)
    return size if size <= MOST_INLINE else max(size, _MOST_BYTES // _MOST_LARGE)
