"""Costs of commands: a table by command, by command and state, or a function.

Costs are apart from the model: another table composes the same commands otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from rtkit.errors import Malformed
from rtkit.planner.command import Command, State

Price = Callable[[Command, State, State], float]
"""Cost of a command that leads from one state to another."""


_MISSPELT = 0.75
"""How much two names must have in common so that one is taken for a misspelling of the other."""


@dataclass(frozen=True, slots=True)
class Row:
    """Cost of a command in the states that have these values."""

    command: str
    when: Mapping[str, Any]
    cost: float


@dataclass(frozen=True, slots=True)
class CostTable:
    """Cost by name of command; rows for certain states go before, the first that fits counts.

    Attributes:
        default: Cost of commands that are not in the table.
    """

    by_command: Mapping[str, float] = field(default_factory=dict)
    rows: tuple[Row, ...] = ()
    default: float = 1

    def price(self, names: Iterable[str]) -> Price:
        """Return the table as a function, for states of these variables.

        Raises:
            Malformed: A row names a variable that there is not.
        """
        places = {name: place for place, name in enumerate(names)}
        rows: dict[str, list[tuple[list[tuple[int, Any]], float]]] = {}
        for row in self.rows:
            unknown = next((name for name in row.when if name not in places), None)
            if unknown is not None:
                raise Malformed(f"cost of {row.command}: no such variable: {unknown}")
            when = [(places[name], value) for name, value in row.when.items()]
            rows.setdefault(row.command, []).append((when, row.cost))
        by_command, default = self.by_command, self.default
        if not rows:
            return lambda command, _before, _after: by_command.get(command.name, default)

        def price(command: Command, before: State, _after: State) -> float:
            for when, cost in rows.get(command.name, ()):
                if all(before[place] == value for place, value in when):
                    return cost
            return by_command.get(command.name, default)

        return price

    @staticmethod
    def check_commands(
        costs: Mapping[str, float] | CostTable | Price | None, names: Collection[str]
    ) -> None:
        """Refuse a misspelt command: one that is not there, and looks like one without a cost.

        A table may serve several problems, so other commands that are not there pass. What a
        function yields cannot be known beforehand.

        Raises:
            Malformed: Names the command, and the nearest there is.
        """
        if costs is None or callable(costs):
            return
        table = costs if isinstance(costs, CostTable) else CostTable(costs)
        priced = dict.fromkeys((*table.by_command, *(row.command for row in table.rows)))
        known = frozenset(names)
        unknown = [name for name in priced if name not in known]
        if not unknown:
            return
        from difflib import get_close_matches

        without = [name for name in known if name not in priced]
        for name in unknown:
            near = get_close_matches(name, without, 1, _MISSPELT)
            if near:
                raise Malformed(f"cost of {name}: no such command (did you mean {near[0]}?)")

    @staticmethod
    def price_of(
        costs: Mapping[str, float] | CostTable | Price | None, names: Iterable[str]
    ) -> Price:
        """Return costs in any form as a function; without any, each command costs 1.

        Raises:
            Malformed: One is no number.
        """
        if callable(costs):
            return costs
        table = costs if isinstance(costs, CostTable) else CostTable(costs or {})
        for name, cost in table.by_command.items():
            if cost is None or isinstance(cost, str):
                raise Malformed(f"cost of {name} is no number: {cost!r}")
        return table.price(names)
