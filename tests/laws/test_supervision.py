"""The law of restarts: whatever ends when, however often, and however the clock jumps ahead."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.deployment.supervision import (
    HEALTHY_S,
    JITTER,
    LONGEST_S,
    MOST,
    WINDOW_S,
    Ledger,
    RestartPolicy,
    RestartRule,
    at_end,
    at_health,
    read_policy,
)
from rtkit.errors import Malformed

policies = st.builds(
    RestartPolicy,
    st.just(RestartRule.ALWAYS),
    st.floats(0.0, LONGEST_S),
    st.integers(1, MOST),
)
lives = st.lists(
    st.tuples(
        st.one_of(st.floats(0.0, 1.0), st.floats(0.0, 100.0)),  # how long it lives [s]
        st.floats(-1.0, 1.0),  # spread
        st.booleans(),  # whether it is well meanwhile
    ),
    max_size=40,
)


@given(policies, lives)
def test_never_more_restarts_than_allowed_and_never_sooner_than_before(policy, stream):
    ledger, now, starts, waits = Ledger(), 1000.0, [], []
    for lived_s, spread, is_well in stream:
        if is_well:
            ledger = at_health(ledger, now, is_well=True)
        was_well_s = lived_s if is_well else 0.0
        now += lived_s
        ledger, wait_s = at_end(ledger, policy, now, spread)
        if wait_s is None:
            assert ledger.is_given_up
            assert at_end(ledger, policy, now + 1000.0, spread) == (ledger, None)
            break
        assert wait_s <= LONGEST_S * (1 + JITTER)
        if was_well_s >= HEALTHY_S:
            waits = []
        waits.append(wait_s)
        assert waits == sorted(waits)
        now += wait_s
        starts.append(now)
    for first, start in enumerate(starts):
        within = [each for each in starts[first:] if each < start + WINDOW_S]
        assert len(within) <= policy.limit


@given(policies, st.lists(st.floats(-1.0, 1.0), min_size=MOST + 1, max_size=MOST + 1))
def test_who_dies_at_every_start_is_given_up(policy, spreads):
    """Unless it takes so long that fewer than the limit fit into the window."""
    ledger, now, made = Ledger(), 0.0, 0
    for spread in spreads:
        ledger, wait_s = at_end(ledger, policy, now, spread)
        if wait_s is None:
            break
        made += 1
        now += wait_s
    assert ledger.is_given_up
    assert made == policy.limit


@given(st.floats(-1.0, 1.0))
def test_who_was_well_for_long_begins_anew(spread):
    policy = RestartPolicy(RestartRule.ALWAYS)
    ledger = Ledger()
    first = at_end(ledger, policy, 0.0, spread)[1]
    for start in itertools.islice(itertools.count(0.0, 100.0), 20):
        ledger, wait_s = at_end(ledger, policy, start, spread)
        assert wait_s == first
        ledger = at_health(ledger, start + 1.0, is_well=True)
        ledger = at_health(ledger, start + 2.0, is_well=True)


def test_health_that_is_broken_off_counts_from_anew():
    ledger, _ = at_end(Ledger(), RestartPolicy(RestartRule.ALWAYS), 0.0, 0.0)
    ledger = at_health(ledger, 1.0, is_well=True)
    ledger = at_health(ledger, 25.0, is_well=False)
    ledger = at_health(ledger, 26.0, is_well=True)
    assert at_end(ledger, RestartPolicy(RestartRule.ALWAYS), 40.0, 0.0)[1] == pytest.approx(0.2)
    assert at_end(ledger, RestartPolicy(RestartRule.ALWAYS), 57.0, 0.0)[1] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("restart", "failure", "orderly"),
    [("never", False, False), ("on-failure", True, False), ("always", True, True)],
)
def test_which_ends_are_answered(restart, failure, orderly):
    policy = read_policy({"rtkit.restart": restart})
    assert (policy.wants(is_failure=True), policy.wants(is_failure=False)) == (failure, orderly)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"rtkit.restart": "sometimes"}, "not one of never, on-failure, always: sometimes"),
        ({"rtkit.restart.delay": "-1"}, r"not a number from 0 to 10 \[s\]: -1"),
        ({"rtkit.restart.delay": "nan"}, "not a number"),
        ({"rtkit.restart.delay": "soon"}, "not a number"),
        ({"rtkit.restart.limit": "0"}, r"not a number from 1 to 5 \[restarts\]: 0"),
        ({"rtkit.restart.limit": "6"}, "not a number from 1 to 5"),
        ({"rtkit.restart.limit": "2.5"}, "not a whole number: 2.5"),
        ({"rtkit.critical": "perhaps"}, "neither yes nor no: perhaps"),
        ({"rtkit.restart.dealy": "1"}, "unknown property of supervision: rtkit.restart.dealy"),
    ],
)
def test_nonsense_is_refused(options, why):
    with pytest.raises(Malformed, match=why):
        read_policy(options)
