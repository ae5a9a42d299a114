"""Functions over commands: treat work with objects and places as one step, and compose.

A function takes a state and yields a path from it, or None where there is none. A sequence of
functions is a function again, and so is the cheapest of several over a fuzzy region. Each leg is a
plan in a cross-section, and equal legs are planned once; `Evaluator` tells which are equal.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, MutableMapping
from math import isclose
from typing import Any, NamedTuple, TypeVar

from rtkit.errors import Impossible, Malformed
from rtkit.fast_dataclass import dataclass
from rtkit.planner.command import State
from rtkit.planner.problem import Problem
from rtkit.planner.result import Step
from rtkit.planner.search import Heuristic, plan
from rtkit.planner.sections import restrict

P = TypeVar("P")
Way = tuple[State, ...]
"""Values of the free variables, at the start and after each step."""


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


class Alike(NamedTuple):
    """Key of a leg that is another one seen otherwise: mirrored, turned, or backwards.

    Attributes:
        key: Legs of the same key are alike.
        turn: From the way of this leg to the one that all legs of the key share. A way has the
            values of the free variables, in their order, at the start and after each step.
        back: The reverse of `turn`.
    """

    key: Hashable
    turn: Callable[[Way], Way]
    back: Callable[[Way], Way]


Key = Callable[[State], Hashable | Alike]
"""Key of a leg from a state; it is to say all that the cheapest way depends on, and no more."""


class Evaluator:
    """Plans legs in cross-sections, and counts.

    An *evaluation* is one search for the cheapest way of a leg, whether or not there is one. A leg
    whose answer is known from before is asked for, but not evaluated again.

    The cache knows a leg by a key. If the caller gives none, it is the problem (the very object),
    the variables that are frozen, the start (the whole state, frozen values included) and the goal.

    A key of the caller may take more legs for the same. Their cheapest way is kept as values of the
    free variables: objects that are alike may be exchanged, those that are far away do not count.
    `Alike` is for mirrors. A known way is walked again, with the commands and costs of the leg that
    asks; where it does not lead to the goal at the same cost, the leg is planned anew. That one is
    impossible is believed.

    Attributes:
        asked: How many legs were asked for.
        evaluations: How many of them were planned; the others were known.
    """

    def __init__(
        self, *, is_caching: bool = True, known: MutableMapping[Any, Any] | None = None
    ) -> None:
        """Begin to count.

        Args:
            is_caching: Whether what is known is used.
            known: Where answers to legs with a key of the caller are kept: a dict that outlives
                this object, a shelf (each key a string then), or the like. A value is None for
                "impossible", or the cost and the way; it can be pickled if the values of the
                variables can.

        Raises:
            Malformed: `known` is no mapping.
        """
        if not isinstance(known, MutableMapping | None):
            raise Malformed(f"known answers are kept in a mapping, not in {known!r}")
        self._own: dict[Hashable, Path | None] = {}
        # Known by their identity, they must live as long as what is known of them.
        self._problems: dict[int, Problem] = {}
        self._known: MutableMapping[Any, Any] = {} if known is None else known
        self._is_caching = is_caching
        self.asked = 0
        self.evaluations = 0

    def leg(
        self,
        problem: Problem,
        free: Iterable[str],
        goal: Mapping[str, Any],
        heuristic: Heuristic | None = None,
        key: Key | None = None,
    ) -> Function:
        """Return the cheapest way to a goal within a cross-section, as a function.

        Args:
            problem: Problem from which commands and costs are taken.
            free: Variables that may change.
            goal: Values desired of them.
            heuristic: Never too high, and consistent; 0 if None.
            key: By what the cache knows the leg; see `Evaluator`.

        Raises:
            Malformed: There is no such variable; from the function: the cache takes no such key, or
                has something else than an answer.
        """
        section = restrict(problem, free)
        self._problems[id(problem)] = problem

        def run(state: State) -> Path | None:
            self.asked += 1
            if key is not None and self._is_caching:
                return self._with_key(key(state), section, state, goal, heuristic)
            own = (id(problem), section.frozen, state, frozenset(goal.items()))
            if not self._is_caching or own not in self._own:
                self._own[own] = self._plan(section, state, goal, heuristic)
            return self._own[own]

        return Function(run)

    def _with_key(
        self,
        key: Hashable | Alike,
        section: Problem,
        state: State,
        goal: Mapping[str, Any],
        heuristic: Heuristic | None,
    ) -> Path | None:
        alike = key if isinstance(key, Alike) else Alike(key, tuple, tuple)
        try:
            is_known = alike.key in self._known
            kept = self._known[alike.key] if is_known else None
            cost, shared = kept if kept is not None else (0, ())
        except (AttributeError, TypeError, ValueError) as error:
            raise Malformed(
                f"the cache has no answers for keys like {alike.key!r}: {error}"
            ) from error
        if is_known:
            if kept is None:
                return None
            path = _walked(section.replaced(start=state, goal=goal), alike.back(shared), cost)
            if path is not None:
                return path
        path = self._plan(section, state, goal, heuristic)
        self._known[alike.key] = None
        if path is not None:
            states = (state, *(step.after for step in path.steps))
            way = tuple(_values(section, each) for each in states)
            self._known[alike.key] = (path.cost, alike.turn(way))
        return path

    def _plan(
        self, section: Problem, state: State, goal: Mapping[str, Any], heuristic: Heuristic | None
    ) -> Path | None:
        self.evaluations += 1
        try:
            found = plan(section.replaced(start=state, goal=goal), heuristic)
        except Impossible:
            return None
        return Path(found.steps, found.cost, found.steps[-1].after if found.steps else state)


def _values(section: Problem, state: State) -> State:
    """Return the values of the free variables."""
    return tuple(value for place, value in enumerate(state) if place not in section.frozen)


def _walked(section: Problem, way: Way, cost: float) -> Path | None:
    """Return the path through these values of the free variables, if it leads to the goal so."""
    states = [*map(tuple, way)]
    state, steps = section.start, list[Step]()
    if states[:1] != [_values(section, state)]:
        return None
    for values in states[1:]:
        found = [
            Step(command, state, after, price)
            for command, after, price in section.successors(state)
            if not section.leaves(state, after) and _values(section, after) == values
        ]
        if not found:
            return None
        steps.append(min(found, key=lambda step: step.cost))
        state = steps[-1].after
    if not section.is_goal(state) or not isclose(sum(step.cost for step in steps), cost):
        return None
    return Path(tuple(steps), cost, state)
