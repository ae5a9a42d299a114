"""Deadlines without drift and without bursts, on a clock that jumps."""

from __future__ import annotations

import math

import pytest

from rtkit.component.contexts.period import NANOSECONDS, Period
from rtkit.errors import Malformed

START = 123_456_789


def test_an_hour_without_drift():
    period = Period(300.0, START)
    now = START
    for _ in range(300 * 3600):
        now = period.advance(now + 1000)
    assert now == START + 3600 * NANOSECONDS
    assert period.skipped == 0


def test_an_overrun_skips_and_keeps_the_phase():
    period = Period(100.0, 0)
    late = 35_000_000
    assert period.advance(late) == 40_000_000
    assert period.skipped == 3
    assert period.advance(40_000_001) == 50_000_000
    assert period.skipped == 3


def test_a_tick_that_began_late_is_made_up_for_once():
    period = Period(100.0, 0)
    assert period.advance(11_000_000, began_ns=9_500_000) == 10_000_000
    assert period.advance(12_000_000, began_ns=11_000_000) == 20_000_000
    assert period.skipped == 0
    assert period.advance(57_000_000, began_ns=56_000_000) == 50_000_000
    assert period.skipped == 2
    assert period.advance(58_000_000, began_ns=57_000_000) == 60_000_000
    assert period.advance(75_000_000, began_ns=60_000_000) == 80_000_000
    assert period.skipped == 3


def test_a_tick_that_ends_at_the_deadline_is_in_time():
    period = Period(100.0, 0)
    assert period.advance(10_000_000) == 10_000_000
    assert period.skipped == 0


def test_no_burst_after_a_long_stop():
    period = Period(1000.0, 0)
    now = 60 * NANOSECONDS
    ticks = 0
    while now < 61 * NANOSECONDS:
        now = max(now, period.advance(now)) + 100_000
        ticks += 1
    assert ticks <= 1001


def test_waiting_time():
    period = Period(10.0, 0)
    period.advance(0)
    assert period.wait_s(40_000_000) == pytest.approx(0.06)
    assert period.wait_s(400_000_000) == 0.0


def test_a_new_rate_and_a_pause_begin_anew():
    period = Period(10.0, 0)
    period.change_rate(1000.0, 5_000_000)
    assert period.rate == 1000.0
    assert period.advance(5_000_001) == 6_000_000
    period.restart(90 * NANOSECONDS)
    assert period.advance(90 * NANOSECONDS) == 90 * NANOSECONDS + 1_000_000
    assert period.skipped == 0


@pytest.mark.parametrize("rate", [0.0, -5.0, math.nan, math.inf])
def test_wrong_rates(rate):
    with pytest.raises(Malformed, match="rate is not a positive number"):
        Period(rate, 0)
