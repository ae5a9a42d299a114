"""Waits that callbacks are granted: those that are over at once, and those that take long."""

from __future__ import annotations

from threading import Event

import pytest

from rtkit.component.contexts import waiting
from rtkit.component.contexts.waiting import grant_by, wait_for
from rtkit.component.contexts.waiting import waiting as waiting_for

LONG_S = 3000.0


class Clock:
    """Stands still but while somebody waits."""

    def __init__(self):
        self.now_ns = 0

    def monotonic_ns(self):
        return self.now_ns


class Bell:
    """Rings so long after one begins to wait for it [s]."""

    def __init__(self, clock, after_s):
        self.clock = clock
        self.left_s = after_s
        self.grants = []
        self.granted = []

    def acquire(self, timeout):
        self.granted.append(sum(self.grants))
        taken_s = min(timeout, self.left_s)
        self.left_s -= taken_s
        self.clock.now_ns += round(taken_s * 1e9)
        return self.left_s <= 0


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(waiting, "time", clock)
    yield clock
    grant_by(None)


def wait(clock, after_s, bound_s):
    wakeup = Bell(clock, after_s)
    grant_by(wakeup.grants.append)
    return wakeup, wait_for(wakeup.acquire, bound_s)


def test_a_long_wait_is_granted_before_and_given_back(clock):
    wakeup, left_s = wait(clock, 2.0, 10.0)
    assert left_s == pytest.approx(8.0)
    assert wakeup.granted[-1] == pytest.approx(10e9)
    assert sum(wakeup.grants) == pytest.approx(2e9)


def test_nothing_is_left_of_a_wait_that_was_in_vain(clock):
    wakeup, left_s = wait(clock, LONG_S, 2.0)
    assert left_s <= 0
    assert sum(wakeup.grants) == pytest.approx(2e9)


def test_brief_waits_are_granted_together(clock):
    grants = []
    grant_by(grants.append)
    for _ in range(1000):
        assert wait_for(Bell(clock, 0.0003).acquire, 1.0) == pytest.approx(0.9997)
    assert sum(grants) == pytest.approx(clock.now_ns, abs=1.1e6)
    assert 0 < len(grants) <= clock.now_ns / 1e6


def test_what_was_owed_goes_with_who_drove_the_thread(clock):
    grant_by(lambda _: None)
    wait_for(Bell(clock, 0.0009).acquire, 1.0)
    wakeup, _ = wait(clock, 0.0009, 1.0)
    assert wakeup.grants == []


def test_who_is_driven_by_nobody_waits_all_the_same():
    wakeup = Event()
    assert wait_for(wakeup.wait, 0.001) <= 0
    wakeup.set()
    assert wait_for(wakeup.wait, 1.0) > 0


@pytest.mark.parametrize("is_idle", [False, True])
def test_an_idle_wait_is_no_work(clock, is_idle):
    driven = grant_by([].append)
    with waiting_for(10.0, is_idle=is_idle):
        clock.now_ns += 2_000_000_000
    assert driven.take_idle_ns() == (2_000_000_000 if is_idle else 0)
