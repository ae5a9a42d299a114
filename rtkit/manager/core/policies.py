"""Chooses the restart policy of a component: its own, its slave's, else the manager's."""

from __future__ import annotations

from rtkit.deployment import actions as act
from rtkit.deployment.extension import with_policy
from rtkit.deployment.health import Reaction, read_rules
from rtkit.deployment.limits import read_limits
from rtkit.deployment.supervision import RestartPolicy, RestartRule, read_policy, restart_of
from rtkit.errors import Refused
from rtkit.manager.core.effects import Procedure
from rtkit.manager.core.limiting import reserve
from rtkit.manager.core.registration import remember
from rtkit.manager.core.state import ManagerState, no_component
from rtkit.rtc.create import parse_create

DEFAULT = "manager.restart"
"""Property of the manager; with the name of a slave added, of what that holds."""


def policy_of(state: ManagerState, create: str) -> RestartPolicy:
    """Return the policy in a create string, else that of its slave, else of the manager.

    Raises:
        Malformed: It makes no sense.
    """
    made = parse_create(create)
    rules = read_rules(made.options)
    read_limits(made.options)
    default = restart_of(DEFAULT, state.settings.text(DEFAULT))
    of_slave = f"{DEFAULT}.{made.place or state.name}"
    default = restart_of(of_slave, state.settings.text(of_slave), default)
    # A rule that says restart is the component's own word, which counts more than that of its slave
    # or manager; without it the rule could do nothing. Its own ``rtkit.restart`` counts most.
    if any(rule.reaction is Reaction.RESTART for rule in rules) and default is RestartRule.NEVER:
        default = RestartRule.ON_FAILURE
    return read_policy(made.options, default)


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
    return (yield from remember(state, action.instance))
