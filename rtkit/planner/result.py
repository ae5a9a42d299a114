"""Results of a search: a plan, all cheapest plans, and statistics of the search."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import perf_counter
from typing import NamedTuple

from rtkit.errors import LimitReached
from rtkit.fast_dataclass import dataclass
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

    def check(self, expanded: int, begin: float) -> None:
        """Refuse to go on with so many states expanded, since `begin` of `perf_counter` [s].

        Raises:
            LimitReached: One of the limits is reached.
        """
        if self.states is not None and expanded >= self.states:
            raise LimitReached(f"no plan among the first {expanded} states looked at")
        if self.seconds is not None and perf_counter() - begin >= self.seconds:
            raise LimitReached(f"no plan found within {self.seconds:g} s")


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
