"""Reference model: the same deployment as one problem of the planner, with all variables.

It serves as comparison: its search knows nothing of how plans are made.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from rtkit.deployment.planning.model import Model, manager_of
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
    for move in every_move(model) if moves is None else moves:
        commands.append(_command(move, places))
        costs[move.text] = move.cost
    start = tuple(model.now(variable) for variable in variables)
    wished = [(places[v], v) for v in model.desired if v in places]

    def is_goal(state: State) -> bool:
        return all(model.allows(variable, state[place]) for place, variable in wished)

    domain = _Anything()
    return Problem(dict.fromkeys(variables, domain), start, is_goal, commands, costs)


def every_move(model: Model) -> Iterator[Operator]:
    """Yield every command that may be possible at some time; for models that are small."""
    operators = Operators(model)
    yield from (operators.start_manager(manager) for manager in model.managers)
    for variable in model.variables():
        if variable.startswith("mod:"):
            if _finds(model, variable[4:]):
                yield operators.load(variable[4:])
            yield operators.unload(variable[4:])
        if variable.startswith("pkg:"):
            yield operators.install(variable[4:])
            yield operators.uninstall(variable[4:])
    for name, unit in model.units.items():
        for place in unit.places:
            # What must be loaded before is looked for when it is loaded.
            if (
                not unit.module
                or model.needed_module(unit, place)
                or _finds(model, f"{manager_of(place)}/{unit.module}")
            ):
                yield operators.create(name, place)
        yield from (operators.delete(name), operators.activate(name))
        yield from (operators.deactivate(name), operators.reset(name))
    for key in (each for each in model.keys if not model.keys[each].is_fixed):
        desired = model.desired.get(f"cfg:{key}", ())
        values = [desired] if isinstance(desired, str) else desired
        yield from (operators.configure(key, value) for value in values)
    for name, connector in model.connectors.items():
        yield operators.disconnect(name)
        if not connector.why_not:
            yield operators.connect(name)


def _finds(model: Model, name: str) -> bool:
    """Return whether a manager finds a module: ``M/X``."""
    manager, _, module = name.partition("/")
    found = model.managers.get(manager, frozenset())
    return found is None or module in found


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
