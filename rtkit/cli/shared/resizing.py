"""Wakes a waiting command when the terminal's size changes or the process is continued."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress

_DISTURBANCES = (signal.SIGWINCH, signal.SIGCONT)
"""Another size; or the shell has had the terminal meanwhile (Ctrl-Z, fg)."""


class ResizeWakeup:
    """Wakeup event: its descriptor is readable from `ring` until `heard`."""

    def __init__(self) -> None:
        self._event = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._event

    def ring(self) -> None:
        """Set the event, from any thread or a signal handler; a closed one is ignored."""
        with suppress(OSError, ValueError):
            os.eventfd_write(self._event, 1)

    def heard(self) -> bool:
        """Return whether the event was set since the last call, and clear it."""
        try:
            os.eventfd_read(self._event)
        except BlockingIOError:
            return False
        return True

    def close(self) -> None:
        """Close the descriptor."""
        os.close(self._event)
        self._event = -1


@contextmanager
def resizing(is_terminal: bool) -> Iterator[ResizeWakeup]:
    """Yield an event that is set when a terminal on stdout must be written anew."""
    wakeup = ResizeWakeup()
    before = {
        number: signal.signal(number, lambda *_: wakeup.ring())
        for number in (_DISTURBANCES if is_terminal else ())
    }
    try:
        yield wakeup
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        wakeup.close()
