"""Cross-sections: a problem with all but a few variables frozen, solved as one step of another."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from rtkit.errors import Impossible
from rtkit.planner.command import Command, Condition, State
from rtkit.planner.problem import Goal, Problem
from rtkit.planner.result import Plan


def restrict(problem: Problem, free: Iterable[str]) -> Problem:
    """Return the same problem with every variable frozen that is not among the free ones.

    Raises:
        Malformed: There is no such variable.
    """
    places = {problem.place(name) for name in free}
    frozen = tuple(place for place in range(len(problem.names)) if place not in places)
    return problem.replaced(frozen=frozen)


def solved_in(
    name: str,
    section: Problem,
    goal: Goal,
    solve: Callable[[Problem], Plan],
    parameters: tuple[Any, ...] = (),
) -> tuple[Command, Callable[[State], Plan | None]]:
    """Return a command that is a whole plan in a section, and what yields that plan of a state.

    Both problems have the same variables. The command is possible where there is such a plan; its
    cost, for the price of the problem one level up, is that plan's.
    """
    known: dict[State, Plan | None] = {}

    def plan_from(state: State) -> Plan | None:
        if state not in known:
            try:
                known[state] = solve(section.replaced(start=state, goal=goal))
            except Impossible:
                known[state] = None
        return known[state]

    def effect(state: State) -> State:
        found = plan_from(state)
        assert found is not None
        return found.steps[-1].after if found.steps else state

    def can(state: State) -> bool:
        found = plan_from(state)
        return found is not None and bool(found.steps)

    condition = Condition(f"{name} can be done and is not done yet", can)
    return Command(name, effect, (condition,), parameters), plan_from
