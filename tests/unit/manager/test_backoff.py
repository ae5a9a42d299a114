"""What ends again and again is started less and less often, until it lives."""

from __future__ import annotations

from rtkit.manager.child_process import Backoff


def test_each_wait_is_longer_up_to_ten_seconds():
    patience, now, waits = Backoff(), 0.0, []
    for _ in range(12):
        patience.begin(now)
        now += 0.2
        waits.append(patience.end(now))
        now += waits[-1]
    assert waits[:6] == [0.0, 0.1, 0.2, 0.4, 0.8, 1.6]
    assert waits == sorted(waits)
    assert waits[-2:] == [10.0, 10.0]


def test_one_that_did_its_work_or_ran_long_ended_by_accident():
    patience = Backoff()
    for _ in range(3):
        patience.begin(0.0)
        patience.end(1.0)
    patience.begin(1.0)
    patience.prove()
    assert (patience.end(2.0), patience.failures) == (0.0, 1)
    patience.begin(2.0)
    assert patience.end(3.0) == 0.1
    patience.begin(3.0)
    assert patience.end(33.0) == 0.0


def test_what_was_proven_of_one_is_not_of_the_next():
    patience = Backoff()
    patience.begin(0.0)
    patience.prove()
    patience.end(1.0)
    patience.begin(1.0)
    patience.end(2.0)
    assert patience.failures == 2


def test_no_number_of_ends_is_too_many():
    patience = Backoff()
    for _ in range(10_000):
        patience.begin(0.0)
        assert patience.end(0.0) <= 10.0
