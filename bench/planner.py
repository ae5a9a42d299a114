"""The planner: successors a second on a space of a million states, beside bare calls of the model.

The floor makes the same successors of the same states without any search: conditions, effects and
costs are called, and nothing is remembered.
"""

from __future__ import annotations

import os
import sys
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from bench.harness import Lines, Row, paired
from rtkit.errors import LimitReached
from rtkit.planner import Limits, Problem, State, plan

_EXAMPLES = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "examples")
_STATES = 30_000
_ROUNDS = 3


def _successors() -> Lines:
    sys.path.insert(0, _EXAMPLES)
    from manipulation.large import Large

    instance = Large(1)
    problem = instance.problem()
    states: list[State] = []
    made = sum(
        1 for state in _looked_at(problem, instance, states) for _ in problem.successors(state)
    )

    def search() -> float:
        return _each(lambda: _search(problem, instance), made)

    def bare() -> float:
        return _each(lambda: [deque(problem.successors(state), 0) for state in states], made)

    figures = paired(search, bare, _ROUNDS)
    what = "A* among 10^6 states, one successor (10 us are 100,000 a second on one core)"
    yield Row(what, "us", *figures, 10.0, False, "the model's own work on the same states")


def _search(problem: Problem, instance: Any) -> None:
    with suppress(LimitReached):
        plan(problem, instance.heuristic, Limits(states=_STATES))


def _looked_at(problem: Problem, instance: Any, states: list[State]) -> list[State]:
    """Return the states that the search expands."""

    def noted(state: State) -> Any:
        states.append(state)
        return problem.commands

    _search(problem.replaced(commands=noted), instance)
    return states


def _each(work: Callable[[], object], count: int) -> float:
    """Return the time of a processor that one of so many takes [us]."""
    begin = time.process_time()
    work()
    return (time.process_time() - begin) / count * 1e6


PARTS = {"successors": _successors}
