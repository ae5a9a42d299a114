"""The goal of a deployment plan: the wanted system, and the permitted means."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rtkit.deployment.facts import Snapshot
from rtkit.deployment.live import LiveIndex
from rtkit.deployment.planning.costs import Costs
from rtkit.deployment.planning.feasibility import NOTHING_KNOWN, Feasibility
from rtkit.deployment.planning.model_builder import NO_STATES, BuiltModel, ModelBuilder
from rtkit.deployment.planning.plan import NO_RANKS, DeploymentPlan, make_plan
from rtkit.deployment.system import WantedSystem
from rtkit.errors import Impossible
from rtkit.rtc.enums import LifeCycleState


@dataclass(frozen=True)
class DeploymentGoal:
    """A wanted system, and how it is to be reached.

    Attributes:
        state: In which every component is to be; None for as it is.
        ranks: Components of lower numbers are activated before those of higher ones.
        parallel: Most actions that are under way at once; 0 for no bound.
        feasibility: What is known of components that do not live yet.
        states: In which single components are to be, instead of `state`.
        absent: Components that are not to be there.
        replaces: What cannot be changed in place is created again.
        prunes: What is not in the system is not to be there.
        is_strict: What would be made with a note on it is to fail instead.
    """

    system: WantedSystem
    state: LifeCycleState | None = LifeCycleState.ACTIVE
    ranks: Mapping[str, int] = field(default_factory=lambda: NO_RANKS)
    costs: Costs = field(default_factory=Costs)
    parallel: int = 0
    feasibility: Feasibility = NOTHING_KNOWN
    states: Mapping[str, LifeCycleState | None] = field(default_factory=lambda: NO_STATES)
    absent: frozenset[str] = frozenset()
    replaces: bool = False
    prunes: bool = False
    is_strict: bool = False

    def survey(
        self, snapshot: Snapshot, began: Snapshot | None = None, *, is_back: bool = False
    ) -> BuiltModel:
        """Return what is wanted over what lives, with what lived when it `began`.

        Raises:
            Impossible: Something else lives where a required component belongs.
        """
        live = LiveIndex(snapshot, self.system, takes_namesakes=True)
        return ModelBuilder(
            self.system,
            live,
            self.state,
            self.costs.values,
            began,
            self.feasibility,
            self.states,
            self.absent,
            self.replaces,
            self.prunes,
            is_back,
        ).run()

    def holds(self, snapshot: Snapshot) -> bool:
        """Return whether the whole desired state holds."""
        try:
            model = self.survey(snapshot).model
        except Impossible:
            return False
        wished = [v for v in model.desired if not v.startswith("cfg:") or v[4:] in model.keys]
        return all(model.allows(variable, model.now(variable)) for variable in wished)

    def plan(self, snapshot: Snapshot, began: Snapshot | None = None) -> DeploymentPlan:
        """Return the cheapest plan from what lives.

        Raises:
            Impossible: There is none.
        """
        return make_plan(self.survey(snapshot, began).model, self.ranks)
