"""The model on the page about problems of one's own: short, and the one of the example."""

from __future__ import annotations

import sys
from itertools import product

from pagekit import ROOT, blocks

sys.path.insert(0, str(ROOT / "examples"))

from manipulation import line

from rtkit.errors import Impossible
from rtkit.planner import plan

MOST_LINES = 30
MODEL = blocks(ROOT / "docs" / "howto" / "planner.md")[0].text


def cost(problem):
    try:
        return plan(problem, ties="any").cost
    except Impossible:
        return None


def test_jaws_carry_and_push_are_built_in_thirty_lines():
    assert len(MODEL.splitlines()) <= MOST_LINES
    names = {"__name__": "jaws"}
    exec(MODEL, names)
    problem = names["problem"]
    asked = [
        (start, goal) for start in product(range(1, 6), (0, 1), range(1, 6)) for goal in range(1, 6)
    ]
    for start, goal in asked:
        costs = cost(problem.replaced(start=start, goal={"y": goal}))
        assert costs == cost(line.carrying(start, {"y": goal}))
    assert len(asked) == 250
