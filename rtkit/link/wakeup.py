"""Wakeup: lets any thread wake the thread that waits for a descriptor."""

from __future__ import annotations

import os
import select
from collections.abc import Iterable
from threading import Lock


class Wakeup:
    """A descriptor that turns readable when it is rung, until it is hushed.

    Whoever rings it may be late: after `close` that does nothing, and rings no descriptor of
    another that has the same number by then.
    """

    def __init__(self) -> None:
        self._descriptor = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._lock = Lock()

    def fileno(self) -> int:
        """Return the descriptor; -1 once it is closed."""
        return self._descriptor

    def ring(self) -> None:
        """Wake who waits."""
        with self._lock:
            if self._descriptor >= 0:
                os.eventfd_write(self._descriptor, 1)

    def hush(self) -> bool:
        """Have it turn readable only when it is rung again; return whether it was rung."""
        try:
            return os.eventfd_read(self._descriptor) > 0
        except BlockingIOError:
            return False

    def wait(self, others: Iterable[int], timeout_s: float | None) -> bool:
        """Wait until it rings, or one of the others can be read; False when the time is up."""
        ready = select.select([self._descriptor, *others], [], [], timeout_s)[0]
        if self._descriptor in ready:
            self.hush()
        return bool(ready)

    def close(self) -> None:
        """Ring no more; without effect when it is closed already."""
        with self._lock:
            if self._descriptor >= 0:
                os.close(self._descriptor)
            self._descriptor = -1
