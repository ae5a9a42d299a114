"""Watches processes of this host by descriptors, so that a reused pid is not mistaken."""

from __future__ import annotations

import os
import select


class ProcessWatch:
    """Watch on one process, from now until it exits."""

    def __init__(self, pid: int) -> None:
        """Begin to watch.

        Raises:
            OSError: There is none of that id, or no descriptor is left.
        """
        self._descriptor = os.pidfd_open(pid)

    @property
    def is_over(self) -> bool:
        """Return whether it has ended."""
        return self.await_end(0.0)

    def await_end(self, timeout_s: float) -> bool:
        """Wait for its end, at most so long [s]; return whether it has ended."""
        watching = select.poll()  # unlike select, it takes descriptors of any number
        watching.register(self._descriptor, select.POLLIN)
        return bool(watching.poll(timeout_s * 1000))

    def close(self) -> None:
        """Watch it no more."""
        os.close(self._descriptor)
