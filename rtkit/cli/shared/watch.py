"""``--watch``: shows the same again and again."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable

from rtkit.cli.shared import terminal

CLEAR = "\x1b[H\x1b[2J"
"""Escape sequence that clears a terminal."""


class WatchedScreen:
    """Repeated output: on a terminal in place of the last one, else behind a `gap`.

    It begins stale, and is shown at most once in a period as long as it stands there.
    """

    def __init__(self, period_s: float, gap: str) -> None:
        self._period_s = period_s
        self._gap = gap
        self._before: list[str] | None = None
        self._shown_at = -period_s
        self._is_stale = True

    def due(self) -> float | None:
        """Return the time of the next output, monotonic [s]; None if nothing has changed."""
        return self._shown_at + self._period_s if self._is_stale else None

    @property
    def is_due(self) -> bool:
        """Return whether the output is due now."""
        due = self.due()
        return due is not None and time.monotonic() >= due

    def stale(self) -> None:
        """Note that something may have changed."""
        self._is_stale = True

    def forget(self) -> None:
        """Note that the last output may have been overwritten."""
        self._before, self._is_stale, self._shown_at = None, True, -self._period_s

    def show(self, look: Callable[[], Iterable[str]]) -> None:
        """Render the output, and write it if it differs from the last one."""
        self._shown_at = time.monotonic()
        lines = list(look())
        if lines != self._before:
            sys.stdout.write(CLEAR if terminal.is_terminal() else self._gap if self._before else "")
            terminal.write(lines)
            sys.stdout.flush()
        self._before, self._is_stale = lines, False


def watch(look: Callable[[], Iterable[str]], period_s: float) -> None:
    """Render again in each period, and show changes, until nobody reads them."""
    from rtkit.cli.shared.signals import resizing
    from rtkit.cli.shared.stdout_reader import wait_for

    sight = WatchedScreen(period_s, "")
    with resizing(terminal.is_terminal()) as wakeup:
        while True:
            sight.stale()
            if wakeup.take():
                sight.forget()
            if sight.is_due:
                sight.show(look)
            wait_for([wakeup.fileno()], sight.due() or time.monotonic() + period_s)
