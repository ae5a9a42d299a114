"""Bound of the values that have arrived for a tool and that it has not dealt with."""

from __future__ import annotations

from collections.abc import Iterable
from threading import Condition

from rtkit.link.local.channel import MOST_INLINE

_MOST_BYTES = 8 << 20
"""What may wait where the next one waits, too."""
_MOST_LARGE = 6
"""How many large values may wait there. As many are in the hands of the tool, and all together are
fewer than a reader may keep in the memory of their writer."""
_MOST_KEPT_BYTES = 512 << 20
"""What may wait where the next one is lost."""
_PATIENCE_S = 60.0


class Backlog:
    """Values that wait for a tool: they are bounded, so that a slow disk does not fill the memory.

    Where none may be lost, few wait, and then who writes does: beyond a number large ones would be
    copied, too, out of the memory that they arrive in.

    Args:
        is_lossless: Whether a value waits for room; else it is refused.
    """

    def __init__(self, *, is_lossless: bool) -> None:
        self._changed = Condition()
        self._is_lossless = is_lossless
        self._most = _MOST_BYTES if is_lossless else _MOST_KEPT_BYTES
        self._cost = 0
        self._is_open = False

    def enter(self, payload: bytes) -> bool:
        """Count a value, which waits for room a minute at most; False where it is refused."""
        cost = self._cost_of(payload)
        with self._changed:
            if self._is_lossless:
                self._changed.wait_for(lambda: self._has_room(cost), _PATIENCE_S)
            elif not self._has_room(cost):
                return False
            self._cost += cost
            return True

    def _has_room(self, cost: int) -> bool:
        return self._is_open or not self._cost or self._cost + cost <= self._most

    def leave(self, payloads: Iterable[bytes]) -> None:
        """Count values no more."""
        with self._changed:
            self._cost -= sum(map(self._cost_of, payloads))
            self._changed.notify_all()

    def open(self) -> None:
        """Let all values in from now on."""
        with self._changed:
            self._is_open = True
            self._changed.notify_all()

    def _cost_of(self, payload: bytes) -> int:
        size = len(payload)
        is_counted = self._is_lossless and size > MOST_INLINE
        return max(size, _MOST_BYTES // _MOST_LARGE) if is_counted else size
