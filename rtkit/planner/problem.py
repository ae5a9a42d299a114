"""Planning problems: variables, a start, a goal, and commands whose successors are made on demand.

The product of the domains is never built: the search makes a state's neighbours when it expands
the state.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from typing import Any, Self

from rtkit.errors import Malformed
from rtkit.planner.command import Command, State
from rtkit.planner.costs import CostTable, Price


class OneOf(frozenset[Any]):
    """Values of which each is as good as the other, in what is desired of a variable."""


Goal = Mapping[str, Any] | Callable[[State], bool]
"""Values of some variables (`OneOf` where several will do), or a predicate of the whole state."""

Commands = Sequence[Command] | Callable[[State], Iterable[Command]]
"""All commands, or a function that offers in a state those which may be possible there."""


class Problem:
    """State variables with finite domains, a start, a goal, commands and their costs.

    A command that would lead out of a domain is not possible there, like one of which a condition
    does not hold.

    Attributes:
        variables: Domain of each variable; a state has their values in this order.
        start: The state in which plans begin.
        goal: Desired values, or a test of a state.
        commands: Possible commands; their order breaks ties between plans.
        costs: Of each command, in numbers greater than 0: a table, or a function.
        frozen: Places of the variables that no command may change (see `restrict`).
    """

    def __init__(
        self,
        variables: Mapping[str, Container[Any]],
        start: Mapping[str, Any] | State,
        goal: Goal,
        commands: Commands,
        costs: Mapping[str, float] | CostTable | Price | None = None,
        frozen: tuple[int, ...] = (),
    ) -> None:
        """Describe a problem.

        Raises:
            Malformed: Start or goal name a variable or value that there is not, costs name a
                misspelt command, or one of them is something else than it is to be.
        """
        _check_kinds(variables, start, goal, commands)
        self.variables = variables
        self.names = tuple(variables)
        self._domains = tuple(variables.values())
        self._places = {name: place for place, name in enumerate(self.names)}
        self.start = self.state(start) if isinstance(start, Mapping) else start
        self._check(self.start)
        self.goal = goal
        self.is_goal = goal if callable(goal) else self._goal_test(goal)
        self.commands = commands
        self.costs = costs
        self.price = CostTable.price_of(costs, self.names)
        if not callable(commands):
            CostTable.check_commands(costs, [command.name for command in commands])
        self.frozen = frozen

    def state(self, values: Mapping[str, Any]) -> State:
        """Return the state that has these values.

        Raises:
            Malformed: A variable has no value, or there is no such variable.
        """
        if values.keys() != self._places.keys():
            names = ", ".join(map(str, sorted(values.keys() ^ self._places.keys())))
            raise Malformed(f"state and variables differ in: {names}")
        return tuple(values[name] for name in self.names)

    def named(self, state: State) -> dict[str, Any]:
        """Return the values of a state by the names of the variables."""
        return dict(zip(self.names, state, strict=True))

    def place(self, name: str) -> int:
        """Return where in a state the value of a variable stands.

        Raises:
            Malformed: There is no such variable.
        """
        if name not in self._places:
            from difflib import get_close_matches

            near = get_close_matches(str(name), list(map(str, self.names)), 1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise Malformed(f"no such variable: {name}{hint}")
        return self._places[name]

    def commands_at(self, state: State) -> Iterable[Command]:
        """Return the commands that may be possible in a state."""
        return self.commands(state) if callable(self.commands) else self.commands

    def successors(self, state: State) -> Iterator[tuple[Command, State, float]]:
        """Yield what can be done in a state, the state after it, and what it costs.

        Whether a state is within the domains is for the caller to ask (see `leaves`): a search
        asks once for each state, not once for each way to it.

        Raises:
            Malformed: A cost is not greater than 0.
        """
        price, frozen = self.price, self.frozen
        for command in self.commands_at(state):
            for condition in command.conditions:
                if not condition.holds(state):
                    break
            else:
                after = command.effect(state)
                if not isinstance(after, tuple):
                    raise self._no_state(after)
                if frozen and any(after[place] != state[place] for place in frozen):
                    continue
                try:
                    cost = price(command, state, after)
                    if not cost > 0:
                        raise Malformed(f"cost of {command} is not greater than 0: {cost}")
                except Exception:
                    # Where there is no state a price need not be one: the domains come first.
                    if self.leaves(state, after):
                        continue
                    raise
                yield command, after, cost

    def leaves(self, before: State, after: State) -> bool:
        """Return whether the step from a state within the domains leads out of them.

        Raises:
            Malformed: It leads to what is no state.
        """
        try:
            for old, new, domain in zip(before, after, self._domains, strict=True):
                if new is not old and new not in domain:
                    return True
        except (TypeError, ValueError) as error:
            raise self._no_state(after) from error
        return False

    def _no_state(self, after: object) -> Malformed:
        what = f"a tuple of {len(self.names)} values that can be hashed"
        return Malformed(f"an effect returned {after!r}, which is not {what}")

    def replaced(self, **changes: Any) -> Self:
        """Return the same problem with another start, goal, costs, or frozen places."""
        kept = {
            name: getattr(self, name)
            for name in ("variables", "start", "goal", "commands", "costs", "frozen")
        }
        return type(self)(**(kept | changes))

    def _check(self, state: State) -> None:
        if len(state) != len(self.names):
            raise Malformed(
                f"the start has {len(state)} values, but there are {len(self.names)} variables"
            )
        for (name, domain), value in zip(self.variables.items(), state, strict=True):
            if value not in domain:
                raise Malformed(f"{name} cannot be {value!r}")

    def _goal_test(self, goal: Mapping[str, Any]) -> Callable[[State], bool]:
        wanted = []
        for name, value in goal.items():
            place = self.place(name)
            values = value if isinstance(value, OneOf) else (value,)
            for each in values:
                if each not in self.variables[name]:
                    raise Malformed(f"{name} cannot be {each!r}")
            wanted.append((place, frozenset(values)))
        return lambda state: all(state[place] in values for place, values in wanted)


def _check_kinds(variables: Any, start: Any, goal: Any, commands: Any) -> None:
    """Refuse what cannot be taken for what it is handed in as.

    Raises:
        Malformed: States which, and what it must satisfy.
    """
    if not isinstance(variables, Mapping):
        raise Malformed(f"variables are a mapping of names to domains, not {_kind(variables)}")
    for name, domain in variables.items():
        if not isinstance(domain, Container):
            raise Malformed(f"the domain of {name} is no collection of values: {domain!r}")
    if not isinstance(start, Mapping | tuple):
        raise Malformed(f"the start is a mapping or a tuple of values, not {_kind(start)}")
    if not isinstance(goal, Mapping) and not callable(goal):
        raise Malformed(f"the goal is a mapping or a function of a state, not {_kind(goal)}")
    if callable(commands):
        return
    if not isinstance(commands, Sequence) or isinstance(commands, str):
        raise Malformed(f"commands are a sequence or a function of a state, not {_kind(commands)}")
    for each in commands:
        if not isinstance(each, Command):
            raise Malformed(f"no command: {each!r}")
        if not isinstance(each.conditions, Sequence):
            kind = _kind(each.conditions)
            raise Malformed(f"conditions of {each} are a tuple of Condition, not {kind}")


def _kind(value: object) -> str:
    return "None" if value is None else type(value).__name__
