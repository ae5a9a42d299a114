"""Chooses the restart policy of a component: its own, its slave's, else the manager's."""

from __future__ import annotations

from rtkit.deployment import actions as act
from rtkit.deployment.extension import with_policy
from rtkit.deployment.health import policy_in, read_rules
from rtkit.deployment.limits import read_limits
from rtkit.deployment.placement.requirements import read_requirements
from rtkit.deployment.supervision import RestartPolicy
from rtkit.errors import Refused
from rtkit.manager.core.effects import Procedure
from rtkit.manager.core.limiting import reserve
from rtkit.manager.core.registration import remember
from rtkit.manager.core.required_devices import note_devices
from rtkit.manager.core.state import ManagerState, no_component
from rtkit.rtc.create import parse_create


def policy_of(state: ManagerState, create: str) -> RestartPolicy:
    """Return the policy in a create string, else that of its slave, else of the manager.

    Raises:
        Malformed: It makes no sense.
    """
    made = parse_create(create)
    read_limits(made.options)
    read_requirements(made.options)
    return policy_in(made.options, made.place or state.name, state.settings.text)


def set_policy(state: ManagerState, action: act.SetPolicy) -> Procedure:
    """Change the policy of a component, and with it its create string."""
    facts = state.components.get(action.instance)
    if facts is None:
        raise no_component(state, action.instance)
    if not facts.create:
        raise Refused(f"{action.instance} was not made here: it has no policy")
    create = with_policy(facts.create, action.policy)
    policy_of(state, create)
    process = state.process_of(action.instance)
    reserve(state, action.instance, create, process)
    state.update(action.instance, create=create)
    state.kept.change(action.instance, create=create)
    (state.ruled.add if read_rules(action.policy) else state.ruled.discard)(action.instance)
    note_devices(state, action.instance, create)
    return (yield from remember(state, action.instance))
