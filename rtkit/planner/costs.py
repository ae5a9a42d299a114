"""Costs of commands: a table by command, by command and state, or a function.

Costs are apart from the model: another table composes the same commands otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass, field
from rtkit.planner.command import Command, State

Price = Callable[[Command, State, State], float]
"""Cost of a command that leads from one state to another."""


_MISSPELT = 0.75
"""How much two names must have in common so that one is taken for a misspelling of the other."""
_SHORTEST = 4
"""Letters of a word that may be told from a name."""


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
        by_command, met = self.by_command, set[str]()

        def price(command: Command, before: State, _after: State) -> float:
            if rows:
                for when, cost in rows.get(command.name, ()):
                    if all(before[place] == value for place, value in when):
                        return cost
            found = by_command.get(command.name)
            if found is not None:
                return found
            if command.name not in met:  # a function may offer it where nobody looked before
                met.add(command.name)
                for slip in (name for name in (*by_command, *rows) if _is_slip(name, command.name)):
                    raise _misspelt(slip, command.name)
            return self.default

        return price

    @staticmethod
    def check_commands(
        costs: Mapping[str, float] | CostTable | Price | None, names: Collection[str]
    ) -> None:
        """Refuse a misspelt command: it is not there, and looks like one that is.

        A table may serve several problems, so other commands that are not there pass: it must look
        like one without a cost, or be one but for a slip of the keys. What a function yields cannot
        be known beforehand; there, slips are told when the search meets the command.

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
            near += [other for other in sorted(known) if _is_slip(name, other)]
            if near:
                raise _misspelt(name, near[0])

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


def _misspelt(name: str, near: str) -> Malformed:
    return Malformed(f"cost of {name}: no such command (did you mean {near}?)")


def _is_slip(name: str, meant: str) -> bool:
    """Return whether a word differs by its case, a letter more or less, or two exchanged.

    Short words are names rather (A, AB), and so are those that differ in digits (block1, block12).
    """
    words, others = name.split(), meant.split()
    differing = [pair for pair in zip(words, others, strict=False) if len(set(pair)) > 1]
    if len(words) != len(others) or len(differing) != 1:
        return False
    short, long = sorted((word.casefold() for word in differing[0]), key=len)
    if short == long or len(long) < _SHORTEST:
        return len(long) >= _SHORTEST
    if len(long) == len(short) + 1:
        return any(c.isalpha() and long[:at] + long[at + 1 :] == short for at, c in enumerate(long))
    pairs = ((at, long[at : at + 2]) for at in range(len(long)))
    return any(
        pair.isalpha() and long[:at] + pair[::-1] + long[at + 2 :] == short for at, pair in pairs
    )
