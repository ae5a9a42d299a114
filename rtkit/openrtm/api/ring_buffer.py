"""Ring buffers that components make themselves, mostly as an argument of their ports."""

from __future__ import annotations

from collections import deque
from typing import Any


class BufferStatus:
    """Outcomes of a write or a read of a buffer, as numbers."""

    BUFFER_OK, BUFFER_ERROR, FULL, EMPTY, NOT_SUPPORTED, TIMEOUT, PRECONDITION_NOT_MET = range(7)
    BUFFER_FULL, BUFFER_EMPTY = FULL, EMPTY


class RingBuffer:
    """A buffer that drops its oldest value when it is full; the buffer of a port is rtkit's own."""

    def __init__(self, length: int = 8) -> None:
        self._items: deque[Any] = deque(maxlen=max(int(length), 1))
        self._last: Any = None

    def init(self, properties: Any) -> None:
        """Take the length of properties."""
        text = properties.getProperty("length")
        if text:
            self.length(int(text))

    def length(self, n: int | None = None) -> int:
        """Return how many values fit, after a change where a number is given."""
        if n is not None and n > 0:
            self._items = deque(self._items, maxlen=n)
        return self._items.maxlen or 0

    def write(self, value: Any, *_: Any) -> int:
        """Take a value."""
        self._items.append(value)
        return BufferStatus.BUFFER_OK

    put = write

    def read(self, *_: Any) -> tuple[int, Any]:
        """Return the outcome and the oldest value, else the last one again."""
        if not self._items:
            return BufferStatus.EMPTY, self._last
        self._last = self._items.popleft()
        return BufferStatus.BUFFER_OK, self._last

    def get(self) -> Any:
        """Return the oldest value, which stays."""
        return self._items[0] if self._items else self._last

    def readable(self) -> int:
        """Return how many values wait."""
        return len(self._items)

    def writable(self) -> int:
        """Return how many more values fit."""
        return self.length() - len(self._items)

    def full(self) -> bool:
        """Return whether the next value takes the place of the oldest."""
        return self.writable() == 0

    def empty(self) -> bool:
        """Return whether no value waits."""
        return not self._items

    def isNew(self) -> bool:
        """Return whether a value waits."""
        return bool(self._items)

    def reset(self) -> int:
        """Drop all values."""
        self._items.clear()
        return BufferStatus.BUFFER_OK
