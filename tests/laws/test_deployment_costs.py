"""Costs that were measured: kept as they are, bounded, on the scale of the table, and stable."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.deployment import actions as act
from rtkit.deployment.planning import measured_times as costs
from rtkit.deployment.planning.default_costs import DEFAULT_COSTS
from rtkit.deployment.planning.measured_times import (
    ENOUGH,
    Mean,
    Times,
    times_from_text,
    times_to_text,
)
from rtkit.errors import Malformed
from rtkit.rtc.enums import Transition

seconds = st.floats(1e-6, 1e3)
kinds = st.sampled_from(list(DEFAULT_COSTS))
types = st.text(st.characters(codec="utf-8"), min_size=1, max_size=8)
names = kinds | st.builds("{} {}".format, kinds, types)
means = st.builds(Mean, st.integers(1, 100), seconds.map(lambda s: round(s, 6)))
times = st.dictionaries(names, means, max_size=20).map(Times)


@given(times)
def test_what_is_kept_is_read_again(known):
    assert times_from_text(times_to_text(known)) == known


@given(st.text() | times.map(times_to_text), st.integers(0, 400), st.integers(0, 5))
def test_a_damaged_file_is_recognised_and_no_more(text, where, length):
    damaged = text[:where] + text[where + length :]
    try:
        read = times_from_text(damaged)
    except Malformed:
        return
    assert all(cost > 0 for cost in read.costs({"A0": "A"}).values())


@given(times, st.dictionaries(types, types, max_size=3))
def test_costs_are_above_nothing_and_on_the_scale_of_the_table(known, components):
    found = known.costs(components)
    assert all(0 < cost < 1e12 for cost in found.values())
    whole = [kind for kind in DEFAULT_COSTS if kind in found]
    assert all(known.means[kind].steps >= ENOUGH for kind in whole)
    if whole and min(found[kind] for kind in whole) > 0.01:
        ratio = sum(found[kind] for kind in whole) / sum(DEFAULT_COSTS[kind] for kind in whole)
        assert 0.75 < ratio < 1.34  # each is rounded by a fifth at most, upwards by a quarter


@given(times, st.sampled_from([0.001, 1000.0]))
def test_a_machine_of_another_speed_makes_the_same_plans(known, factor):
    slower = Times({n: Mean(m.steps, m.seconds * factor) for n, m in known.means.items()})
    for name, cost in known.costs({}).items():
        # A cost that lies just between two numbers may be rounded to either.
        assert slower.costs({})[name] == pytest.approx(cost, rel=0.6)


@given(st.lists(st.sampled_from(["A", "B", "C"]), max_size=40))
@settings(max_examples=30)
def test_means_are_of_what_was_noted(order):
    known = Times()
    for number, name in enumerate(order):
        action = act.ChangeState(f"{name}0", "0", Transition.ACTIVATE)
        known = known.noting([(action, float(number))], {f"{each}0": each for each in "ABC"})
    for name in set(order):
        own = [number for number, each in enumerate(order) if each == name]
        mean = known.means[f"activate {name}"]
        assert (mean.steps, mean.seconds) == (len(own), pytest.approx(sum(own) / len(own)))


def test_it_never_grows_without_bound():
    action = act.Create("Motor?instance_name=M")
    known = Times()
    for number in range(1200):
        known = known.noting([(action, 1.0)], {"M": f"T{number}"})
    assert len(known.means) <= 501
    assert known.means["create"] == Mean(100, 1.0)
    assert "create T1199" in known.means
    assert "create T0" not in known.means
    assert len(times_to_text(known)) < 1 << 16


@pytest.mark.parametrize(
    ("action", "kind"),
    [
        (act.Create("X"), "create"),
        (act.Create("X?manager_name=s"), "create_slave"),
        (act.Load("X"), "load"),
        (act.ChangeState("X", "0", Transition.RESET), "reset"),
        (act.SetParameters("X", "default"), "configure"),
        (act.SetRate("X", "0", 1.0), "configure"),
    ],
)
def test_what_counts_as_which_kind(action, kind):
    assert costs.kind_of(action) == kind
