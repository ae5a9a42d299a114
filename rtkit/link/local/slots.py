"""Shared memory in which large values travel between processes of one host.

A slot is a piece of memory without a name, so nothing of it is left when its processes end, killed
or not, and ``/dev/shm`` is not needed. Its owner writes a value into it and passes its descriptor
to a reader once; from then on a number stands for it. The owner writes into it again only when all
readers have given it back, and gives it up where that can never be known.
"""

from __future__ import annotations

import fcntl
import os
import weakref
from collections.abc import Callable, Sequence
from functools import lru_cache
from threading import Lock
from typing import Any

from rtkit.link.ends import Payload

SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
"""What keeps memory that another process can read as large as it is."""
OFFSET = 4
"""Where a value begins, so that numbers of 8 bytes behind its header of 4 are aligned [bytes]."""
_STEPS = 8
"""How many sizes of slots there are between one power of two and the next."""
_PAGE = 4096
_MOST_FREE = 64 << 20
"""How much may lie unused [bytes]."""


class Slot:
    """A piece of shared memory of this process.

    Attributes:
        number: By which readers know it.
        size: Of its memory [bytes].
        content: What was written into it last, while anybody has it.
        descriptor: Of its memory.
        memory: Its memory.
        users: How many connections have it at present.
        is_spent: Whether a reader may keep it for ever.
    """

    __slots__ = ("content", "descriptor", "is_spent", "memory", "number", "size", "users")

    def __init__(self, number: int, size: int) -> None:
        import mmap

        self.number, self.size = number, size
        self.content: Payload | None = None
        self.users = 0
        self.is_spent = False
        self.descriptor = os.memfd_create("rtkit", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.posix_fallocate(self.descriptor, 0, size)  # else a write could end the process
            fcntl.fcntl(self.descriptor, fcntl.F_ADD_SEALS, SEALS)
            self.memory = mmap.mmap(self.descriptor, size)
        except OSError:
            os.close(self.descriptor)
            raise

    def close(self) -> None:
        """Give the memory back; readers that have it keep it."""
        self.memory.close()
        os.close(self.descriptor)


class SlotPool:
    """The slots of one process; any thread may use it."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._free: list[Slot] = []
        self._free_bytes = 0
        self._count = 0
        self._last: Slot | None = None

    def fill(self, value: Payload, size: int, ended: Sequence[Slot] = ()) -> Slot:
        """Return a slot that holds a value of that size [bytes], with one user more.

        The very value that was written last is not written again, for its next reader. What has
        ended is released first, so that the memory used last is used again.

        Raises:
            OSError: No memory, or no descriptor, can be had.
        """
        wanted = _rounded(OFFSET + size)
        with self._lock:
            for each in ended:
                self._release(each)
            slot = self._take(value, wanted)
        if slot.content is not value:
            at = OFFSET
            for part in value if isinstance(value, list) else [value]:
                end = at + len(part)
                slot.memory[at:end] = part
                at = end
            slot.content = value
            self._last = slot
        return slot

    def _take(self, value: Payload, wanted: int) -> Slot:
        last = self._last
        if last is not None and last.users and last.content is value:
            last.users += 1
            return last
        for index, slot in enumerate(self._free):
            if slot.size == wanted:
                del self._free[index]
                self._free_bytes -= wanted
                break
        else:
            self._count += 1
            slot = Slot(self._count, wanted)
        slot.users = 1
        return slot

    def release(self, slots: Sequence[Slot]) -> None:
        """Note that a connection has them no more."""
        with self._lock:
            for slot in slots:
                self._release(slot)

    def _release(self, slot: Slot) -> None:
        slot.users -= 1
        if slot.users:
            return
        slot.content = None
        if slot.is_spent:
            slot.close()
            return
        self._free.insert(0, slot)  # used next, while it is in the cache
        self._free_bytes += slot.size
        while self._free_bytes - slot.size > _MOST_FREE:
            oldest = self._free.pop()
            self._free_bytes -= oldest.size
            oldest.close()

    def close(self) -> None:
        """Give back what lies unused."""
        with self._lock:
            self._free_bytes = 0
            while self._free:
                self._free.pop().close()


@lru_cache(maxsize=16)
def _rounded(size: int) -> int:
    """Return the size of the slots for values of a size [bytes]."""
    step = max(_PAGE, (1 << (size - 1).bit_length()) // _STEPS)
    return -(-size // step) * step


class SeenSlots:
    """Slots of another process, as a reader of them has them."""

    def __init__(self) -> None:
        self._memories: dict[int, Any] = {}

    def learn(self, number: int, descriptor: int) -> None:
        """Take over the descriptor of a slot.

        Raises:
            OSError: It is no shared memory, or it could shrink, which would end its readers.
        """
        import mmap

        try:
            if fcntl.fcntl(descriptor, fcntl.F_GET_SEALS) & SEALS != SEALS:
                raise OSError("shared memory that is not sealed")
            size = os.fstat(descriptor).st_size
            # What a reader may do to its view changes neither the slot nor what others see.
            self._memories[number] = mmap.mmap(descriptor, size, access=mmap.ACCESS_COPY)
        finally:
            os.close(descriptor)

    def view(
        self, number: int, size: int, done: Callable[[object], object]
    ) -> tuple[memoryview, object]:
        """Return a view of a value, and what has to be kept for `done` to be called.

        That happens when nothing refers to the memory of the view any more.

        Raises:
            KeyError: There is no such slot.
            ValueError: It is smaller.
        """
        import ctypes

        # An object for each use: whatever is made of the view, an array too, keeps it alive.
        used = (ctypes.c_ubyte * size).from_buffer(self._memories[number], OFFSET)
        return memoryview(used).toreadonly().cast("B"), weakref.ref(used, done)

    def forget(self, number: int) -> None:
        """Let go of a slot; views of it stay."""
        self._memories.pop(number, None)
