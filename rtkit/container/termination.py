"""Turns TERM signals into a descriptor that becomes readable: the request to end a slave."""

from __future__ import annotations

import os
import signal


class Term:
    """Ending by TERM: noticed at once, whichever thread the kernel delivers it to.

    A handler alone would run only when the main thread next leaves a wait of its own.
    """

    def __init__(self) -> None:
        self._read, write = os.pipe()
        for descriptor in (self._read, write):
            os.set_blocking(descriptor, False)
        signal.signal(signal.SIGTERM, lambda *_: None)
        signal.set_wakeup_fd(write, warn_on_full_buffer=False)

    def fileno(self) -> int:
        """Return the descriptor that turns readable at any signal."""
        return self._read

    def has_come(self) -> bool:
        """Return whether a TERM was among the signals."""
        return signal.SIGTERM in os.read(self._read, 4096)
