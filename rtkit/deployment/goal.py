"""The goal of a deployment plan: the wanted system, and the permitted means."""

from __future__ import annotations

from rtkit.deployment.facts import Snapshot
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.planning.deployment_plan import DeploymentPlan, make_plan
from rtkit.deployment.planning.model_builder import BuiltModel, ModelBuilder, WantedDeployment
from rtkit.errors import Impossible


class DeploymentGoal(WantedDeployment):
    """A wanted deployment that is compared with what lives, and planned."""

    def survey(
        self, snapshot: Snapshot, began: Snapshot | None = None, *, is_back: bool = False
    ) -> BuiltModel:
        """Return what is wanted over what lives, with what lived when it `began`.

        Raises:
            Impossible: Something else lives where a required component belongs.
        """
        live = LiveIndex(snapshot, self.system, takes_namesakes=True)
        return ModelBuilder(self, live, began, is_back=is_back).run()

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
