"""A bell that rings when the terminal has changed its size."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager


class Bell:
    """Something to wait for: its descriptor is readable from the ringing until it is heard."""

    def __init__(self) -> None:
        self._event = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._event

    def ring(self) -> None:
        """Ring; a signal handler may."""
        os.eventfd_write(self._event, 1)

    def heard(self) -> bool:
        """Whether it has rung since this was asked last."""
        try:
            os.eventfd_read(self._event)
        except BlockingIOError:
            return False
        return True

    def close(self) -> None:
        """Be no more."""
        os.close(self._event)


@contextmanager
def resizing(is_terminal: bool) -> Iterator[Bell]:
    """Have a bell ring at each new size, if there is a terminal that could have one."""
    bell = Bell()
    before = signal.signal(signal.SIGWINCH, lambda *_: bell.ring()) if is_terminal else None
    try:
        yield bell
    finally:
        if is_terminal:
            signal.signal(signal.SIGWINCH, before)
        bell.close()
