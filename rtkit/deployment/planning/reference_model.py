"""Reference model: the same deployment as one problem of the planner, with all variables.

It verifies plans, and it serves as comparison: its search knows nothing of how plans are made.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from rtkit.deployment.planning.model import Model
from rtkit.deployment.planning.operators import Operator, Operators, Requirement
from rtkit.planner import Command, Condition, Plan, Problem, State, Statistics, Step


class _Anything:
    """A domain of every value."""

    def __contains__(self, value: object) -> bool:
        return isinstance(value, str)


def problem_of(model: Model, moves: Iterable[Operator] | None = None) -> Problem:
    """Return a deployment as a problem; its commands are all there are, or those given."""
    variables = list(model.variables())
    places = {variable: place for place, variable in enumerate(variables)}
    commands, costs = [], {}
    for move in Operators(model).every() if moves is None else moves:
        commands.append(_command(move, places))
        costs[move.text] = move.cost
    start = tuple(model.now(variable) for variable in variables)
    wished = [(places[v], v) for v in model.desired if v in places]

    def is_goal(state: State) -> bool:
        return all(model.allows(variable, state[place]) for place, variable in wished)

    domain = _Anything()
    return Problem(dict.fromkeys(variables, domain), start, is_goal, commands, costs)


def judge(model: Model, moves: Iterable[Operator]) -> str:
    """Return the first thing that is wrong with a plan, by the number of its step; or nothing.

    Has the same result as verifying it on the whole problem, and checks only what steps touch.
    """
    state = {variable: model.now(variable) for variable in model.variables()}
    for number, move in enumerate(moves, 1):
        broken = next((need for need in move.needs if not need.holds(state[need.variable])), None)
        if broken is not None:
            return f"step {number} ({move.text}): does not hold: {broken}"
        state.update(move.changes)
    for variable, value in state.items():
        if not model.allows(variable, value):
            return f"what is desired does not hold at the end: {variable}={value}"
    return ""


def plan_of(problem: Problem, moves: Sequence[Operator]) -> Plan:
    """Return moves as a plan of the problem, as they claim to be: nothing is checked."""
    commands = {command.name: command for command in problem.commands_at(problem.start)}
    steps, state = [], problem.start
    for move in moves:
        command = commands[move.text]
        after = command.effect(state)
        steps.append(Step(command, state, after, move.cost))
        state = after
    cost = sum(move.cost for move in moves)
    return Plan(tuple(steps), cost, cost, Statistics(0, 0, 0))


def _command(move: Operator, places: Mapping[str, int]) -> Command:
    changes = [(places[variable], value) for variable, value in move.changes]

    def effect(state: State) -> State:
        after = list(state)
        for place, value in changes:
            after[place] = value
        return tuple(after)

    conditions = tuple(_condition(need, places[need.variable]) for need in move.needs)
    return Command(move.text, effect, conditions)


def _condition(need: Requirement, place: int) -> Condition:
    return Condition(str(need), lambda state: need.holds(state[place]))
