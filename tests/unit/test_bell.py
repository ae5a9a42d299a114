"""The bell that the thread of a context waits for."""

from __future__ import annotations

import threading

from rtkit.container.bell import Bell


def test_it_rings_until_it_is_silenced() -> None:
    bell = Bell()
    assert not bell.is_ringing
    bell.ring()
    bell.ring()
    bell.wait()
    assert bell.is_ringing
    bell.silence()
    bell.silence()
    assert not bell.is_ringing
    bell.wait(0.001)
    assert not bell.is_ringing


def test_any_thread_wakes_the_one_that_waits() -> None:
    bell = Bell()
    others = [threading.Thread(target=bell.ring) for _ in range(4)]
    for thread in others:
        thread.start()
    bell.wait()
    for thread in others:
        thread.join()
    assert bell.is_ringing
