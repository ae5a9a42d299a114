"""A bell: who waits for it wakes, and who rings late harms nobody."""

from __future__ import annotations

import os
import select

from rtkit.link.wakeup import Wakeup


def is_ringing(descriptor: int) -> bool:
    return bool(select.select([descriptor], [], [], 0)[0])


def test_it_rings_until_it_is_hushed() -> None:
    wakeup = Wakeup()
    assert not is_ringing(wakeup.fileno())
    wakeup.hush()
    wakeup.ring()
    wakeup.ring()
    assert is_ringing(wakeup.fileno())
    wakeup.hush()
    assert not is_ringing(wakeup.fileno())
    wakeup.ring()
    assert wakeup.wait((), 0.0)
    assert not wakeup.wait((), 0.0)
    wakeup.close()


def test_who_rings_late_rings_nobody_else_s() -> None:
    wakeup = Wakeup()
    number = wakeup.fileno()
    wakeup.close()
    wakeup.close()
    other = os.eventfd(0, os.EFD_NONBLOCK)
    assert other == number  # the kernel gives the least number that is free
    wakeup.ring()
    assert wakeup.fileno() == -1
    assert not is_ringing(other)
    os.close(other)
