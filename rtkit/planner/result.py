"""Results of a search: a plan, all cheapest plans, and statistics of the search."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from rtkit.planner.command import Command, State


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a search; None for as far as it takes.

    Attributes:
        states: That are expanded.
        seconds: That it takes [s].
    """

    states: int | None = None
    seconds: float | None = None


class Statistics(NamedTuple):
    """Statistics of a search: states expanded and generated, and its duration [s]."""

    expanded: int
    generated: int
    time_s: float


class Step(NamedTuple):
    """One command of a plan, the states before and after it, and what it costs there."""

    command: Command
    before: State
    after: State
    cost: float


@dataclass(frozen=True, slots=True)
class Plan:
    """Commands that lead from a start to what is desired.

    Attributes:
        lower_bound: No plan is cheaper than this, which the search has proved.
    """

    steps: tuple[Step, ...]
    cost: float
    lower_bound: float
    statistics: Statistics

    @property
    def is_optimal(self) -> bool:
        """Return whether it is proved that no plan is cheaper."""
        return self.cost <= self.lower_bound

    @property
    def commands(self) -> tuple[str, ...]:
        """The commands, as they are shown."""
        return tuple(str(step.command) for step in self.steps)


@dataclass(frozen=True, slots=True)
class OptimalPlans:
    """Every cheapest plan of a problem.

    Attributes:
        count: How many there are.
        make: Yields them, in the order of their commands.
    """

    cost: float
    count: int
    statistics: Statistics
    make: Callable[[], Iterator[Plan]]

    def __iter__(self) -> Iterator[Plan]:
        return self.make()
