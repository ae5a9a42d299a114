"""Counts the values of a numbered stream where both of its ends see the number."""

from __future__ import annotations


class SentCount:
    """The number of values that a sender has sent, in memory that its receiver reads, too.

    Raises:
        OSError: It cannot be mapped.
        ValueError: It is too small.
    """

    SIZE = 4096

    def __init__(self, descriptor: int) -> None:
        import mmap

        self._value = memoryview(mmap.mmap(descriptor, self.SIZE)).cast("Q")

    @property
    def value(self) -> int:
        """The number."""
        return self._value[0]

    def next(self) -> int:
        """Return the number of the next value, which is sent now."""
        number = self._value[0]
        self._value[0] = number + 1
        return number
