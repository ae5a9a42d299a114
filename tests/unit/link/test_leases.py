"""Uses of shared memory that a sender lends."""

from __future__ import annotations

import os

import pytest

from rtkit.link.local.leases import MOST, BorrowedUses, LentSlots
from rtkit.link.local.slots import Slot


@pytest.fixture
def lent() -> LentSlots:
    return LentSlots()


@pytest.fixture
def borrowed(lent: LentSlots) -> BorrowedUses:
    return BorrowedUses(os.dup(lent.descriptor))


def test_a_slot_comes_back_when_its_use_has_ended(lent: LentSlots, borrowed: BorrowedUses) -> None:
    slots = [Slot(number, 4096) for number in range(3)]
    uses = [lent.lend(slot) for slot in slots]
    assert lent.ended() == []
    borrowed.end(uses[1])
    assert lent.ended() == [slots[1]]
    assert lent.ended() == []
    assert len(lent.uses) == 2
    assert lent.close() == [slots[0], slots[2]]


def test_one_slot_may_be_lent_twice(lent: LentSlots, borrowed: BorrowedUses) -> None:
    slot = Slot(1, 4096)
    first, second = lent.lend(slot), lent.lend(slot)
    borrowed.end(first)
    borrowed.end(first)  # a receiver that ends a use twice ends no other one
    assert lent.ended() == [slot]
    borrowed.end(second)
    assert lent.ended() == [slot]


def test_uses_are_numbered_anew(lent: LentSlots, borrowed: BorrowedUses) -> None:
    slot = Slot(1, 4096)
    for _ in range(3 * MOST):
        borrowed.end(lent.lend(slot))
        assert lent.ended() == [slot]
    for _ in range(3 * MOST):
        lent.take_back(lent.lend(slot))
    assert not lent.uses


def test_a_receiver_is_told_whether_the_sender_waits(
    lent: LentSlots, borrowed: BorrowedUses
) -> None:
    use = lent.lend(Slot(1, 4096))
    assert not borrowed.end(use)
    lent.await_end(is_awaited=True)
    assert borrowed.end(use)
    lent.await_end(is_awaited=False)
    assert not borrowed.end(use)


def test_a_use_that_no_page_holds_is_refused(borrowed: BorrowedUses) -> None:
    with pytest.raises(IndexError):
        borrowed.end(1 << 31)


def test_a_page_that_could_shrink_is_refused() -> None:
    descriptor = os.memfd_create("page")
    os.ftruncate(descriptor, 4096)
    with pytest.raises(OSError, match="not sealed"):
        BorrowedUses(descriptor)
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(descriptor)
