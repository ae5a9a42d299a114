"""What is to be done about the end of a component: its own word, its slave's, the manager's."""

from __future__ import annotations

from rtkit.deployment.health import Reaction, read_rules
from rtkit.deployment.supervision import Policy, Restart, read_policy, restart_of
from rtkit.manager.core.state import State
from rtkit.rtc.create import parse_create

DEFAULT = "manager.restart"
"""Property of the manager; with the name of a slave added, of what that holds."""


def policy_of(state: State, create: str) -> Policy:
    """Return the policy that a create string says, over that of its slave and of the manager.

    Raises:
        Malformed: It makes no sense.
    """
    made = parse_create(create)
    rules = read_rules(made.options)
    default = restart_of(DEFAULT, state.settings.text(DEFAULT))
    of_slave = f"{DEFAULT}.{made.place or state.name}"
    default = restart_of(of_slave, state.settings.text(of_slave), default)
    if any(rule.reaction is Reaction.RESTART for rule in rules) and default is Restart.NEVER:
        default = Restart.ON_FAILURE
    return read_policy(made.options, default)
