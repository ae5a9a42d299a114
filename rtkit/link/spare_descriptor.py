"""Turns away whoever connects when no descriptor is left: else the wait for a listener never waits.

A listener can be read as long as somebody waits there, and to refuse them takes a descriptor, too.
"""

from __future__ import annotations

import os
import socket
from contextlib import suppress


class SpareDescriptor:
    """A descriptor that is kept for that."""

    def __init__(self) -> None:
        self._descriptor = os.open(os.devnull, os.O_RDONLY)

    def turn_away(self, listener: socket.socket) -> None:
        """Hang up on who waits at a listener.

        Raises:
            OSError: Another thread was quicker to take the descriptor: it can be tried again.
        """
        self.close()
        try:
            listener.accept()[0].close()
        finally:
            with suppress(OSError):  # there is none for the next time
                self._descriptor = os.open(os.devnull, os.O_RDONLY)

    def close(self) -> None:
        """Give it back."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = -1
