"""A bell: who waits for it wakes, and who rings late harms nobody."""

from __future__ import annotations

import os
import select

from rtkit.tree.bell import Bell


def is_ringing(descriptor: int) -> bool:
    return bool(select.select([descriptor], [], [], 0)[0])


def test_it_rings_until_it_is_hushed() -> None:
    bell = Bell()
    assert not is_ringing(bell.fileno())
    bell.hush()
    bell.ring()
    bell.ring()
    assert is_ringing(bell.fileno())
    bell.hush()
    assert not is_ringing(bell.fileno())
    bell.ring()
    assert bell.wait((), 0.0)
    assert not bell.wait((), 0.0)
    bell.close()


def test_who_rings_late_rings_nobody_else_s() -> None:
    bell = Bell()
    number = bell.fileno()
    bell.close()
    bell.close()
    other = os.eventfd(0, os.EFD_NONBLOCK)
    assert other == number  # the kernel gives the least number that is free
    bell.ring()
    assert bell.fileno() == -1
    assert not is_ringing(other)
    os.close(other)
