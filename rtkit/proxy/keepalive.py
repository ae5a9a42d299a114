"""Keepalive of a peer that owes an answer: asks it for a sign of life, then gives it up."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

ASKED_S = 5.0
"""Silence after which a peer that owes an answer is asked for a sign of life [s]."""
DEAD_S = 15.0
"""Silence after which the connection is given up [s]."""


class Keepalive:
    """Measures how long nothing has been received."""

    def __init__(self) -> None:
        self._since = monotonic()
        self._is_asked = False

    def end(self) -> None:
        """Note that the peer was heard from, or owes nothing."""
        self._since, self._is_asked = monotonic(), False

    def check(
        self, now: float, ask: Callable[[], object], give_up: Callable[[str, str], object]
    ) -> None:
        """Ask for a sign of life when it has lasted long; give up, saying why, when too long."""
        silent_s = now - self._since
        if silent_s > DEAD_S and self._is_asked:
            give_up(f"no answer within {DEAD_S:g} s", "timeout")
        elif silent_s > ASKED_S and not self._is_asked:
            self._is_asked = True
            ask()
