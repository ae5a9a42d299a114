"""Uses of shared memory that a sender lends to a receiver, noted in a page that both have.

The receiver ends a use by clearing a byte, which takes no system call; the sender looks there
before it sends the next large value. A sender that waits for memory says so in the page, and is
sent a packet. Neither side trusts the other with more than its own values: a receiver that clears
bytes too early finds its own values changed.
"""

from __future__ import annotations

import fcntl
import os
from typing import Any

from rtkit.link.local.slots import SEALS, Slot

_SIZE = 4096
_IS_AWAITED = 0
"""Where the byte stands that says whether the sender waits; those of uses are behind it."""
MOST = 256
"""How many uses a page can have at a time."""


class LentSlots:
    """Slots that a sender has lent over one connection.

    Attributes:
        uses: Those that have not ended, and the slot of each.

    Raises:
        OSError: There is no memory, or no descriptor, for a page.
    """

    def __init__(self) -> None:
        import mmap

        self.descriptor = os.memfd_create("rtkit", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.posix_fallocate(self.descriptor, 0, _SIZE)
            fcntl.fcntl(self.descriptor, fcntl.F_ADD_SEALS, SEALS)
            self._page = mmap.mmap(self.descriptor, _SIZE)
        except OSError:
            os.close(self.descriptor)
            raise
        self.uses: dict[int, Slot] = {}
        self._free = list(range(MOST, 0, -1))

    def lend(self, slot: Slot) -> int:
        """Begin a use of a slot; return its number."""
        use = self._free.pop()
        self._page[use] = 1
        self.uses[use] = slot
        return use

    def take_back(self, use: int) -> bool:
        """End a use that was not told to the receiver; False if it has ended since."""
        if self.uses.pop(use, None) is None:
            return False
        self._free.append(use)
        return True

    def ended(self) -> list[Slot]:
        """Return the slots of uses that the receiver has ended, and forget them."""
        page, uses = self._page, self.uses
        slots = []
        for use in list(uses):
            if not page[use]:
                self._free.append(use)
                slots.append(uses.pop(use))
        return slots

    def await_end(self, *, is_awaited: bool) -> None:
        """Have the receiver send a packet at the next end of a use, or not."""
        self._page[_IS_AWAITED] = is_awaited

    def close(self) -> list[Slot]:
        """Give up the page; return the slots that the receiver may still use."""
        os.close(self.descriptor)
        left = list(self.uses.values())
        self.uses.clear()
        return left


class BorrowedUses:
    """Uses of slots of a sender, as its receiver ends them; it takes over a descriptor.

    Raises:
        OSError: It is no page of uses, or it could shrink, which would end this process.
    """

    def __init__(self, descriptor: int) -> None:
        import mmap

        try:
            if fcntl.fcntl(descriptor, fcntl.F_GET_SEALS) & SEALS != SEALS:
                raise OSError("a page of uses that is not sealed")
            self._page: Any = mmap.mmap(descriptor, _SIZE)
        finally:
            os.close(descriptor)

    def end(self, use: int) -> bool:
        """End a use; return whether the sender waits for that.

        Raises:
            IndexError: There is no such use.
        """
        page = self._page
        page[use] = 0
        return bool(page[_IS_AWAITED])
