"""Functions over commands: treat work with objects and places as one step, and compose.

A function takes a state and yields a path from it, or None where there is none. A sequence of
functions is a function again, and so is the cheapest of several over a fuzzy region. Each leg is a
plan in a cross-section, and equal legs are planned once.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

from rtkit.errors import Impossible
from rtkit.planner.command import State
from rtkit.planner.problem import Problem
from rtkit.planner.result import Plan, Step
from rtkit.planner.search import Heuristic, plan
from rtkit.planner.sections import restrict

P = TypeVar("P")


class Path(NamedTuple):
    """Path of a function from one state: its steps, their cost, the state at the end."""

    steps: tuple[Step, ...]
    cost: float
    end: State


@dataclass(frozen=True, slots=True)
class Function:
    """A function from states to paths.

    Attributes:
        run: Returns the path from a state; None where there is none.
    """

    run: Callable[[State], Path | None]

    def __call__(self, state: State) -> Path | None:
        """Return the path from a state; None where there is none."""
        return self.run(state)

    def followed_by(self, other: Function) -> Function:
        """Return this function and then the other."""

        def run(state: State) -> Path | None:
            first = self.run(state)
            then = other.run(first.end) if first is not None else None
            if first is None or then is None:
                return None
            return Path(first.steps + then.steps, first.cost + then.cost, then.end)

        return Function(run)


NOTHING = Function(lambda state: Path((), 0, state))
"""The function that does nothing."""


def minimise(
    over: Iterable[P],
    make: Callable[[P], Function],
    bound: Callable[[State, P], float] | None = None,
) -> Function:
    """Return the cheapest of the functions that `make` makes of the places of a fuzzy region.

    With a bound, which is never above the cost with that place, the most promising place is tried
    first, and what cannot be better any more is not tried. Of equally cheap ones the first tried
    counts.
    """
    places = list(over)

    def run(state: State) -> Path | None:
        best: Path | None = None
        ranked = [(bound(state, place) if bound is not None else 0, place) for place in places]
        if bound is not None:
            ranked.sort(key=lambda each: each[0])
        for least, place in ranked:
            if bound is not None and best is not None and least >= best.cost:
                break
            path = make(place).run(state)
            if path is not None and (best is None or path.cost < best.cost):
                best = path
        return best

    return Function(run)


class Evaluator:
    """Plans legs in cross-sections, and counts.

    Attributes:
        asked: How many legs were asked for.
        evaluations: How many of them were planned; the others were known.
    """

    def __init__(self, *, is_caching: bool = True) -> None:
        self._known: dict[Hashable, Plan | None] = {}
        # Known by their identity, they must live as long as what is known of them.
        self._problems: dict[int, Problem] = {}
        self._is_caching = is_caching
        self.asked = 0
        self.evaluations = 0

    def leg(
        self,
        problem: Problem,
        free: Iterable[str],
        goal: Mapping[str, Any],
        heuristic: Heuristic | None = None,
    ) -> Function:
        """Return the cheapest way to a goal within a cross-section, as a function."""
        section = restrict(problem, free)
        self._problems[id(problem)] = problem

        def run(state: State) -> Path | None:
            found = self._plan(id(problem), section, state, goal, heuristic)
            if found is None:
                return None
            return Path(found.steps, found.cost, found.steps[-1].after if found.steps else state)

        return Function(run)

    def _plan(
        self,
        problem: int,
        section: Problem,
        state: State,
        goal: Mapping[str, Any],
        heuristic: Heuristic | None,
    ) -> Plan | None:
        self.asked += 1
        key = (problem, section.frozen, state, frozenset(goal.items()))
        if self._is_caching and key in self._known:
            return self._known[key]
        self.evaluations += 1
        found: Plan | None
        try:
            found = plan(section.replaced(start=state, goal=goal), heuristic)
        except Impossible:
            found = None
        self._known[key] = found
        return found
