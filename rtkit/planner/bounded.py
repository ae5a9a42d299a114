"""Bounded-cost search: any heuristic may guide it, a lower bound proves how good the plan is."""

from __future__ import annotations

from heapq import heappop, heappush
from itertools import count
from time import perf_counter

from rtkit.errors import Impossible, Malformed
from rtkit.planner.command import State
from rtkit.planner.problem import Problem
from rtkit.planner.result import Limits, Plan, Statistics, Step
from rtkit.planner.search import NO_LIMITS, Heuristic


def plan_within(
    problem: Problem,
    factor: float,
    guide: Heuristic,
    heuristic: Heuristic | None = None,
    limits: Limits = NO_LIMITS,
) -> Plan:
    """Return a plan that costs at most `factor` times the cheapest; it states what is proved.

    Args:
        problem: Problem to solve.
        factor: At least 1.
        guide: Guess of what is left to be paid; it may be too high.
        heuristic: Never too high; 0 if None. It alone decides what is proved.
        limits: How far the search may go.

    Raises:
        Impossible: The search reached all that can be reached, and no goal is there.
        LimitReached: Nothing is known yet, as a limit was reached before.
        Malformed: `factor` is below 1.
    """
    if not factor >= 1:
        raise Malformed(f"a plan cannot be cheaper than the cheapest: factor {factor:g}")
    begin = perf_counter()
    bound = heuristic or (lambda _: 0)
    costs: dict[State, float] = {problem.start: 0}
    ways: dict[State, Step] = {}
    number = count()
    # Each state is in both; what was taken from one is passed over in the other.
    by_bound = [(bound(problem.start), next(number), 0.0, problem.start)]
    by_guide = [(guide(problem.start), next(number), 0.0, problem.start)]
    done: dict[State, float] = {}
    expanded = generated = 0
    while True:
        for heap in (by_bound, by_guide):
            while heap and _is_old(heap[0], costs, done):
                heappop(heap)
        if not by_bound:
            raise Impossible(f"no goal among all {len(costs)} states that can be reached")
        lowest, state, guided = by_bound[0][0], by_bound[0][3], by_guide[0][3]
        if costs[guided] + bound(guided) <= factor * lowest:
            state = guided
        if problem.is_goal(state):
            statistics = Statistics(expanded, generated, perf_counter() - begin)
            whole = costs[state]
            return Plan(_way(problem, ways, state), whole, min(lowest, whole), statistics)
        limits.check(expanded, begin)
        done[state] = costs[state]
        expanded += 1
        for command, after, price in problem.successors(state):
            generated += 1
            whole = costs[state] + price
            if after not in costs and problem.leaves(state, after):
                continue
            if after not in costs or whole < costs[after]:
                costs[after] = whole
                ways[after] = Step(command, state, after, price)
                heappush(by_bound, (whole + bound(after), next(number), whole, after))
                heappush(by_guide, (guide(after), next(number), whole, after))


def _is_old(
    entry: tuple[float, int, float, State], costs: dict[State, float], done: dict[State, float]
) -> bool:
    _, _, cost, state = entry
    return done.get(state) == costs[state] or cost > costs[state]


def _way(problem: Problem, ways: dict[State, Step], state: State) -> tuple[Step, ...]:
    steps = []
    while state != problem.start:
        steps.append(ways[state])
        state = steps[-1].before
    return tuple(reversed(steps))
