"""Duties of the manager's loop: what it does by itself, and when."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Duty(NamedTuple):
    """Work that is done when its time has come, or that looks itself in each turn of the loop."""

    name: str
    due_at: Callable[[], float | None]
    work: Callable[[], object]
    is_each_turn: bool = False

    def is_due(self, now: float) -> bool:
        """Return whether it is to be done at monotonic time `now` [s]."""
        moment = self.due_at()
        return self.is_each_turn or (moment is not None and now >= moment)
