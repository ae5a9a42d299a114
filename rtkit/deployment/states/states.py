"""States of one system over its goal: finds the present one and plans the ways to others."""

from __future__ import annotations

from typing import NamedTuple

from rtkit.deployment.facts import Snapshot
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.planning.deployment_plan import DeploymentPlan
from rtkit.deployment.states.machine import SystemStates
from rtkit.deployment.states.variants import variant
from rtkit.errors import Impossible
from rtkit.fast_dataclass import replace


class Way(NamedTuple):
    """Way from the live system to one state.

    Attributes:
        why: Why there is no plan; empty where there is one.
    """

    state: str
    plan: DeploymentPlan | None
    why: str = ""


class States:
    """The states of one system over its goal.

    Attributes:
        name: Identity of the system profile.
        machine: States and events.
        base: The goal that all of the profile is active, of which states are differences.
    """

    def __init__(self, name: str, machine: SystemStates, base: DeploymentGoal) -> None:
        self.name = name
        self.machine = machine
        self.base = base
        self._goals = {state: self._goal(state) for state in machine.table}

    def goal(self, state: str) -> DeploymentGoal:
        """Return what is wanted in a state."""
        return self._goals[state]

    def now(self, snapshot: Snapshot, last: str = "") -> str:
        """Return the state that the system is in; empty for none.

        Of several that hold it is the `last` one, else the one with the most desired values.
        """
        held = [name for name in self.machine.table if self.holds(name, snapshot)]
        if last in held:
            return last
        return max(held, key=lambda name: len(self.machine.wishes[name]), default="")

    def holds(self, state: str, snapshot: Snapshot) -> bool:
        """Return whether the desired state of the system in one of its states holds."""
        return self._goals[state].holds(snapshot)

    def way(self, state: str, snapshot: Snapshot) -> Way:
        """Return how a state is reached."""
        try:
            return Way(state, self._goals[state].plan(snapshot))
        except Impossible as error:
            return Way(state, None, str(error))

    def _goal(self, state: str) -> DeploymentGoal:
        conditions = self.machine.conditions.values()
        watched = {(each.component, each.name) for each in conditions}
        made = variant(self.base.system, self.machine.wishes[state], watched)
        return replace(self.base, system=made.system, states=made.states, absent=made.absent)
