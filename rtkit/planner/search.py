"""A* over states made on demand: the cheapest plan with proof, or all of them.

The search expands states in the order of (cost so far + heuristic, steps so far). With a consistent
heuristic that order never turns back, so every cheapest way of fewest steps to a state is known
before any goal is reached. Of these, the search returns the plan whose commands come first. If any
of them will do, it goes on with the state that is nearest to a goal, and leaves other ties alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from heapq import heappop, heappush
from itertools import count
from math import isfinite
from time import perf_counter
from typing import Any, Literal

from rtkit.errors import Impossible, Malformed
from rtkit.planner.command import State
from rtkit.planner.problem import Problem
from rtkit.planner.result import Limits, OptimalPlans, Plan, Statistics, Step

Heuristic = Callable[[State], float]
"""At most what the cheapest way from a state to a goal costs; consistent."""

Ties = Literal["first", "any"]
"""Which of several cheapest plans: that of fewest steps and then of first commands, or any."""

NO_LIMITS = Limits()
_SLACK = 1e-9
"""Part by which rounding may violate the consistency of a heuristic."""


def plan(
    problem: Problem,
    heuristic: Heuristic | None = None,
    limits: Limits = NO_LIMITS,
    *,
    ties: Ties = "first",
) -> Plan:
    """Return the cheapest plan; of several that of fewest steps, then of first commands.

    Args:
        problem: Problem to solve.
        heuristic: Never too high, and consistent; 0 if None.
        limits: How far the search may go.
        ties: ``"any"`` for any of the cheapest plans, though the same one each time. The search
            then expands fewer states: of those that may be on a cheapest way it takes the one with
            the least left to be paid, and it ends with the first goal that is proved.

    Raises:
        Impossible: The search reached all that can be reached, and no goal is there.
        LimitReached: Nothing is known yet, as a limit was reached before.
        Malformed: The heuristic is negative or not consistent, or a cost not above 0; or there are
            no such ties.
    """
    if ties not in ("first", "any"):
        raise Malformed(f'ties are "first" or "any", not {ties!r}')
    search = _Search(problem, heuristic, limits, takes_any=ties == "any")
    cost = search.run(finds_all=False)
    way = search.any_way() if ties == "any" else search.first_way()
    return Plan(way, cost, cost, search.statistics())


def optimal_plans(
    problem: Problem, heuristic: Heuristic | None = None, limits: Limits = NO_LIMITS
) -> OptimalPlans:
    """Return every cheapest plan, counted and to be listed; a float counts as the decimal it shows.

    Raises:
        Impossible: The search reached all that can be reached, and no goal is there.
        LimitReached: Nothing is known yet, as a limit was reached before.
        Malformed: The heuristic is negative or not consistent, or a cost not above 0.
    """
    search = _Search(problem, heuristic, limits)
    cost = search.run(finds_all=True)
    statistics = search.statistics()

    def make() -> Iterator[Plan]:
        return (Plan(way, cost, cost, statistics) for way in search.ways())

    return OptimalPlans(cost, search.count(), statistics, make)


class _Node:
    """Search node of a state.

    Attributes:
        steps: Those of the shortest cheapest way; its rank among equal totals if any way will do.
        ways: Ways into it: a state before, the place of its command, the next state before, … A
            flat tuple, as there are millions: lists of pairs are what the collector looks through.
    """

    __slots__ = ("cost", "heuristic", "is_closed", "steps", "ways")

    def __init__(self, cost: float, steps: float, heuristic: float, *way: Any) -> None:
        self.cost = cost
        self.steps = steps
        self.heuristic = heuristic
        self.is_closed = False
        self.ways: tuple[Any, ...] = way

    def pairs(self) -> Iterator[tuple[State, int]]:
        """Yield states before with the places of commands that lead here."""
        return zip(self.ways[::2], self.ways[1::2], strict=True)


class _Search:
    def __init__(
        self,
        problem: Problem,
        heuristic: Heuristic | None,
        limits: Limits,
        *,
        takes_any: bool = False,
    ) -> None:
        self._problem = problem
        self._takes_any = takes_any
        self._heuristic = self._exactly(heuristic) if heuristic is not None else _nothing
        self._decimals: dict[float, Any] = {}
        self._limits = limits
        self._nodes: dict[State, _Node] = {}
        self._heap: list[tuple[float, float, int, State]] = []
        self._number = count(1)
        self._goals: list[State] = []
        self._expanded = 0
        self._generated = 0
        self._begin = perf_counter()

    def statistics(self) -> Statistics:
        return Statistics(self._expanded, self._generated, perf_counter() - self._begin)

    def run(self, *, finds_all: bool) -> float:
        """Search until all goals of least cost (and of fewest steps) are known; return the cost."""
        nodes, heap, is_goal = self._nodes, self._heap, self._problem.is_goal
        start = self._problem.start
        nodes[start] = _Node(0, 0, self._estimate(start))
        heap.append((nodes[start].heuristic, 0, 0, start))
        best: tuple[float, float] | None = None
        while heap:
            total, steps, _, state = heappop(heap)
            if best is not None and (total > best[0] if finds_all else (total, steps) > best):
                break
            node = nodes[state]
            if node.is_closed:
                continue
            node.is_closed = True
            if is_goal(state):
                if node.heuristic > 0:
                    raise Malformed(f"heuristic of a goal is not 0: {state}")
                self._goals.append(state)
                best = best or (total, steps)
                if self._takes_any:
                    break
                continue
            self._limits.check(self._expanded, self._begin)
            self._expanded += 1
            self._expand(state, node)
        if best is None:
            raise Impossible(f"no goal among all {len(nodes)} states that can be reached")
        cost: float = nodes[self._goals[0]].cost
        # Costs given as floats give a float; fractions given by the caller stay.
        return float(cost) if self._decimals else cost

    def _expand(self, state: State, node: _Node) -> None:
        """Take in what follows a state."""
        # The innermost loop of all that is planned: nothing is looked up twice here.
        nodes, heap, estimate, number = self._nodes, self._heap, self._heuristic, self._number
        cost_before, steps, own = node.cost, node.steps + 1, node.heuristic
        leaves, exact, takes_any = self._problem.leaves, self._exact, self._takes_any
        place = 0
        for place, (_, after, cost) in enumerate(self._problem.successors(state), 1):
            if isinstance(cost, float):
                cost = exact(cost)
            whole = cost_before + cost
            known = nodes.get(after)
            if known is None:
                if leaves(state, after):
                    continue
                rest = estimate(after)
                rank: float = steps
                if takes_any:
                    # The goal goes first of all that cost as much: nothing else is expanded then.
                    rank = -1 if self._problem.is_goal(after) else rest
                known = nodes[after] = _Node(whole, rank, rest, state, place)
                if not rest >= 0:
                    raise Malformed(f"heuristic is negative at {after}: {rest}")
                heappush(heap, (whole + rest, rank, next(number), after))
            elif whole < known.cost and not known.is_closed:
                if not takes_any:
                    known.steps = steps
                known.cost, known.ways = whole, (state, place)
                heappush(heap, (whole + known.heuristic, known.steps, next(number), after))
            elif whole == known.cost and not takes_any:
                known.ways += (state, place)
                if steps < known.steps and not known.is_closed:
                    known.steps = steps
                    heappush(heap, (whole + known.heuristic, steps, next(number), after))
            rest = cost + known.heuristic
            if own > rest and own > rest * (1 + _SLACK):
                raise Malformed(f"heuristic is not consistent between {state} and {after}")
        self._generated += place

    def _estimate(self, state: State) -> float:
        value = self._heuristic(state)
        if not value >= 0:
            raise Malformed(f"heuristic is negative at {state}: {value}")
        return value

    def _exactly(self, heuristic: Heuristic) -> Heuristic:
        def estimate(state: State) -> float:
            value = heuristic(state)
            exact: float = self._exact(value) if isinstance(value, float) else value
            return exact

        return estimate

    def _exact(self, number: float) -> Any:
        """Return the decimal that a float stands for: sums of these are equal where they should.

        With floats 0.1 + 0.2 is dearer than 0.3, and ways that cost the same are no ties.
        """
        found: Any = self._decimals.get(number)
        if found is None:
            found = number
            if number.is_integer():
                found = int(number)
            elif isfinite(number):
                from fractions import Fraction  # with all that it imports 5 ms, seldom needed

                found = Fraction(f"{number:.12g}")
            self._decimals[number] = found
        return found

    # the results

    def any_way(self) -> tuple[Step, ...]:
        """Return the way by which the goal was met."""
        steps: list[Step] = []
        state = self._goals[0]
        while state != self._problem.start:
            state, place = self._nodes[state].ways
            steps.append(self._step(state, place))
        return tuple(reversed(steps))

    def first_way(self) -> tuple[Step, ...]:
        """Return the way of fewest steps whose commands come first."""
        nodes = self._nodes
        fewest = min(nodes[goal].steps for goal in self._goals)
        goals = {goal for goal in self._goals if nodes[goal].steps == fewest}
        following = self._following(goals, is_fewest=True)
        steps, state = [], self._problem.start
        while state not in goals:
            place, _ = min(following[state])
            steps.append(self._step(state, place))
            state = steps[-1].after
        return tuple(steps)

    def ways(self) -> Iterator[tuple[Step, ...]]:
        """Yield all cheapest ways, those of first commands first."""
        goals = set(self._goals)
        following = self._following(goals, is_fewest=False)
        ahead = [iter(sorted(following.get(self._problem.start, ())))]
        steps: list[Step] = []
        if self._problem.start in goals:
            yield ()
            return
        while ahead:
            found = next(ahead[-1], None)
            if found is None:
                ahead.pop()
                if steps:
                    steps.pop()
                continue
            place, before = found
            steps.append(self._step(before, place))
            after = steps[-1].after
            if after in goals:
                yield tuple(steps)
                steps.pop()
            else:
                ahead.append(iter(sorted(following[after])))

    def count(self) -> int:
        """Return how many cheapest ways there are."""
        nodes, goals = self._nodes, set(self._goals)
        following = self._following(goals, is_fewest=False)
        involved = goals | following.keys()
        ways = {self._problem.start: 1}
        for state in sorted(involved, key=lambda state: nodes[state].cost):
            if state != self._problem.start:
                ways[state] = sum(ways.get(before, 0) for before, _ in nodes[state].pairs())
        return sum(ways[goal] for goal in goals)

    def _following(
        self, goals: set[State], *, is_fewest: bool
    ) -> dict[State, list[tuple[int, State]]]:
        """Return the commands by their place, of each state on a cheapest way to a goal."""
        nodes = self._nodes
        following: dict[State, list[tuple[int, State]]] = {}
        seen, left = set(goals), list(goals)
        while left:
            state = left.pop()
            for before, place in nodes[state].pairs():
                if is_fewest and nodes[before].steps + 1 != nodes[state].steps:
                    continue
                following.setdefault(before, []).append((place, before))
                if before not in seen:
                    seen.add(before)
                    left.append(before)
        return following

    def _step(self, state: State, place: int) -> Step:
        for number, (command, after, cost) in enumerate(self._problem.successors(state), 1):
            if number == place:
                return Step(command, state, after, cost)
        raise Malformed(f"commands at {state} differ from one look to the next")


def _nothing(_state: State) -> float:
    return 0
