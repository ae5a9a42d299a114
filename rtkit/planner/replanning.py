"""Replanning: carries a plan out in a world that may differ from the model, and plans again then.

Observations are recorded as facts, and the record outlives the plan: later plans use it.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import Protocol

from rtkit.errors import LimitReached
from rtkit.fast_dataclass import dataclass, field
from rtkit.planner.command import State
from rtkit.planner.problem import Problem
from rtkit.planner.result import Plan, Step


@dataclass(frozen=True, slots=True)
class Observation:
    """Observation of a world: its state, and facts outside any state (an unknown object)."""

    state: State
    facts: frozenset[Hashable] = frozenset()


class World(Protocol):
    """A world in which plans are carried out."""

    def look(self) -> Observation:
        """Return what is seen now."""

    def perform(self, step: Step) -> Observation:
        """Carry a step out, as far as that goes, and return what is seen after it."""


@dataclass(slots=True)
class Execution:
    """Result of carrying a plan out.

    Attributes:
        facts: All that was found out; to be given to the next execution.
        plans: The first plan, and each one that was made on the way.
        done: The steps that came out as planned.
        surprises: States seen instead, one for each plan that was broken off.
    """

    facts: set[Hashable] = field(default_factory=set)
    plans: list[Plan] = field(default_factory=list)
    done: list[Step] = field(default_factory=list)
    surprises: list[Observation] = field(default_factory=list)

    @property
    def cost(self) -> float:
        """Return the cost of the steps that came out as planned."""
        return sum(step.cost for step in self.done)


def execute(
    problem: Callable[[State, frozenset[Hashable]], Problem],
    world: World,
    solve: Callable[[Problem], Plan],
    facts: Iterable[Hashable] = (),
    most_plans: int = 1000,
) -> Execution:
    """Reach a goal in a world, planning from what is observed whenever it differs.

    Args:
        problem: Makes the problem from a state and from what is known; its goal stays the same.
        world: Where.
        solve: Makes a plan.
        facts: Facts known from before.
        most_plans: How often it is planned, before a world that never behaves is given up.

    Raises:
        Impossible: From where things are now, as is known by now, there is no way.
        LimitReached: The world differed too often.
    """
    execution = Execution(set(facts))
    seen = world.look()
    execution.facts |= seen.facts
    while len(execution.plans) < most_plans:
        known = frozenset(execution.facts)
        plan = solve(problem(seen.state, known))
        execution.plans.append(plan)
        surprise = _carry_out(plan, world, execution)
        if surprise is None:
            return execution
        execution.surprises.append(surprise)
        seen = surprise
    raise LimitReached(f"the world differed from {most_plans} plans")


def _carry_out(plan: Plan, world: World, execution: Execution) -> Observation | None:
    """Carry a plan out; return the observation that was not expected, if any."""
    for step in plan.steps:
        seen = world.perform(step)
        if seen.state == step.after:
            execution.done.append(step)
        is_new = not seen.facts <= execution.facts
        execution.facts |= seen.facts
        if is_new or seen.state != step.after:
            return seen
    return None
