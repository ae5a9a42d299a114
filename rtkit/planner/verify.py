"""Verifies a plan independently of its planner: executes every command again."""

from __future__ import annotations

from math import isclose

from rtkit.planner.command import Command, State
from rtkit.planner.problem import Problem
from rtkit.planner.result import Plan, Step


def verify(problem: Problem, plan: Plan) -> str:
    """Return the first thing that is wrong with a plan, by the number of its step; or nothing."""
    state, cost = problem.start, 0.0
    for number, step in enumerate(plan.steps, 1):
        why = _fault(problem, step, state)
        if why:
            return f"step {number} ({step.command}): {why}"
        state, cost = step.after, cost + step.cost
    if not problem.is_goal(state):
        return f"what is desired does not hold at the end: {_text(problem, state)}"
    if not isclose(cost, plan.cost, rel_tol=1e-9):
        return f"the steps cost {cost:g}, not {plan.cost:g}"
    return ""


def _fault(problem: Problem, step: Step, state: State) -> str:
    if step.before != state:
        return f"begins at {_text(problem, step.before)}, not at {_text(problem, state)}"
    command = _offered(problem, step.command, state)
    if command is None:
        return "there is no such command"
    broken = next((each for each in command.conditions if not each.holds(state)), None)
    if broken is not None:
        return f"does not hold: {broken.name}"
    after = command.effect(state)
    if after != step.after:
        return f"leads to {_text(problem, after)}, not to {_text(problem, step.after)}"
    for place, (name, domain) in enumerate(problem.variables.items()):
        if after[place] is not state[place] and after[place] not in domain:
            return f"{name} cannot be {after[place]!r}"
        if place in problem.frozen and after[place] != state[place]:
            return f"{name} is frozen"
    price = problem.price(command, state, after)
    return "" if isclose(price, step.cost) else f"costs {price:g}, not {step.cost:g}"


def _offered(problem: Problem, command: Command, state: State) -> Command | None:
    found = (c for c in problem.commands_at(state) if c.identity == command.identity)
    return next(found, None)


def _text(problem: Problem, state: State) -> str:
    return ", ".join(f"{name}={value}" for name, value in problem.named(state).items())
