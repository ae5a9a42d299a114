"""Taking objects on random sites costs the same however legs are known, and choices are tried."""

from __future__ import annotations

import sys

from hypothesis import given, settings
from hypothesis import strategies as st
from pagekit import ROOT

sys.path.insert(0, str(ROOT / "examples"))

from manipulation import take

from rtkit.planner import Evaluator

WIDTH, HEIGHT = 5, 4
places = st.tuples(st.integers(1, WIDTH), st.integers(1, HEIGHT))


@st.composite
def sites(draw):
    """Return what a site is made of: walls, where hand and objects are, and their shapes."""
    names = (take.HAND, "A", "B1", "B2")
    start = draw(st.lists(places, min_size=4, max_size=4, unique=True))
    goal, *region = draw(st.lists(places, min_size=3, max_size=4, unique=True))
    walls = draw(st.frozensets(places, max_size=5)) - {*start, goal, *region}
    shapes = {"A": draw(st.sampled_from([((0, 0),), ((0, 0), (0, 1))]))}
    return walls, dict(zip(names, start, strict=True)), shapes, goal, region


@given(sites())
@settings(max_examples=40, deadline=None)
def test_known_legs_and_the_best_first_cost_what_all_of_them_planned_cost(made):
    walls, start, shapes, goal, region = made
    costs, evaluations = [], []
    for is_caching, is_best_first in ((False, False), (True, False), (True, True)):
        evaluator = Evaluator(is_caching=is_caching)
        site = take.Site(WIDTH, HEIGHT, walls, start, shapes, evaluator)
        least = (lambda _hand: 0) if is_best_first else None
        cleared = site.take_all(["B1", "B2"], region, site.take("A", goal), least=least)
        path = cleared(site.state)
        costs.append(path and path.cost)
        evaluations.append(evaluator.evaluations)
        if path is not None:
            assert path.end[1] == goal
            assert path.cost == sum(step.cost for step in path.steps)
    assert costs[0] == costs[1] == costs[2]
    assert evaluations[0] >= evaluations[1] >= evaluations[2]
