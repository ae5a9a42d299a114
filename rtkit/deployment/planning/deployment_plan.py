"""Plans a deployment: decides assignments, puts the steps in order, verifies the result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from time import perf_counter

from rtkit.deployment.planning.decide import check_managers, decide
from rtkit.deployment.planning.explain import explained
from rtkit.deployment.planning.model import ABSENT, NO, UP, Model
from rtkit.deployment.planning.operators import Operator, judge
from rtkit.deployment.planning.sequencing import order, sequence
from rtkit.errors import Impossible
from rtkit.planner import layers

NO_RANKS: Mapping[str, int] = {}


@dataclass(frozen=True)
class DeploymentPlan:
    """Steps from the live state to the desired state.

    Attributes:
        moves: In an order in which they can be done one after the other.
        before: Of each step the earlier ones that must be done before it, by their places.
        gap: By how much it may be dearer than the cheapest; 0 when that is proved.
        looked_at: Combinations of what may become of components that were searched.
        time_s: How long it took [s].
    """

    model: Model
    moves: tuple[Operator, ...]
    before: tuple[frozenset[int], ...]
    gap: float = 0
    looked_at: int = 0
    time_s: float = field(default=0, compare=False)

    @property
    def cost(self) -> float:
        """Return the cost of all steps together."""
        return sum(move.cost for move in self.moves)

    @cached_property
    def layers(self) -> tuple[tuple[int, ...], ...]:
        """Steps that need nothing of each other, by their places; each as early as can be."""
        return tuple(map(tuple, layers([set(each) for each in self.before])))

    @property
    def kept(self) -> tuple[int, int, int]:
        """Return how many managers, components and connections live and are ended by no step."""
        model = self.model
        ended = {(move.kind, move.subject) for move in self.moves}
        managers = sum(model.now(f"mgr:{name}") == UP for name in model.managers)
        units = sum(
            model.now(f"cmp:{name}") != ABSENT and ("delete", name) not in ended
            for name in model.units
        )
        connectors = sum(
            model.now(f"con:{name}") != NO and ("disconnect", name) not in ended
            for name in model.connectors
        )
        return managers, units, connectors


def make_plan(model: Model, ranks: Mapping[str, int] = NO_RANKS) -> DeploymentPlan:
    """Return the cheapest plan, judged by carrying it out on the model.

    Args:
        model: Present, possible and desired values.
        ranks: Components with lower numbers are activated before those with higher ones.

    Raises:
        NoPlan: Nothing leads there; names desired values that cannot hold together.
    """
    begin = perf_counter()
    try:
        check_managers(model)
        decision = decide(model)
    except Impossible as error:
        raise explained(model, error) from error
    moves = sequence(model, decision.assignments, ranks)
    why = judge(model, moves)
    if why:
        raise AssertionError(f"a plan that does not hold was made: {why}")
    before = tuple(map(frozenset, order(moves, ranks)))
    return DeploymentPlan(
        model, tuple(moves), before, decision.gap, decision.looked_at, perf_counter() - begin
    )
