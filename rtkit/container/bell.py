"""A bell that one thread waits for: what an Event does, in a third of the time."""

from __future__ import annotations

from _thread import allocate_lock


class Bell:
    """Bell that any thread rings; the only one that waits for it silences it."""

    def __init__(self) -> None:
        self._silence = allocate_lock()
        self._silence.acquire()

    @property
    def is_ringing(self) -> bool:
        """Return whether it was rung since it was silenced."""
        return not self._silence.locked()

    def ring(self) -> None:
        """Wake the thread that waits, or the next one that would."""
        try:
            self._silence.release()
        except RuntimeError:
            return  # it rings already

    def silence(self) -> None:
        """Have it ring no more."""
        self._silence.acquire(blocking=False)

    def wait(self, timeout_s: float = -1) -> None:
        """Wait until it rings, which it still does then, or for so long [s]."""
        if self._silence.acquire(timeout=timeout_s):
            self.ring()
