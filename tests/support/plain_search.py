"""A plain A* that prefers deep nodes: the measure for how many states a search may expand."""

from __future__ import annotations

from collections.abc import Callable
from heapq import heappop, heappush
from itertools import count

from rtkit.planner import Problem, State


def deep_a_star(
    problem: Problem, heuristic: Callable[[State], float] = lambda _: 0
) -> tuple[float | None, int]:
    """Return the least cost (None if impossible), and how many states were expanded for it.

    Of equal totals it takes the node that has cost most so far, of these the first one met.
    """
    costs: dict[State, float] = {problem.start: 0}
    closed: set[State] = set()
    number = count()
    heap = [(heuristic(problem.start), 0.0, next(number), problem.start)]
    while heap:
        _, _, _, state = heappop(heap)
        if state in closed:
            continue
        if problem.is_goal(state):
            return costs[state], len(closed)
        closed.add(state)
        for command in problem.commands_at(state):
            if not all(condition.holds(state) for condition in command.conditions):
                continue
            after = command.effect(state)
            if any(after[problem.place(n)] not in d for n, d in problem.variables.items()):
                continue
            whole = costs[state] + problem.price(command, state, after)
            if after not in costs or whole < costs[after]:
                costs[after] = whole
                heappush(heap, (whole + heuristic(after), -whole, next(number), after))
    return None, len(closed)
