"""Reads the requests of users to components since their creation, as their process reports them.

What was asked last is desired, recorded or not; what is desired and was not asked since a component
was made is still to be done.

See decision 41.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.errors import Malformed
from rtkit.manager.core.desired import DesiredComponent, DesiredState
from rtkit.manager.core.record_desired import note
from rtkit.rtc.serde import decode

Asked = Mapping[str, tuple[Action, ...]]
"""Actions by component."""

_ACTIONS: Mapping[object, type[Action]] = {
    "set": act.SetParameters,
    "activate_set": act.ActivateSet,
    "change_state": act.ChangeState,
    "set_rate": act.SetRate,
    "set_structure": act.SetStructure,
    "set_events": act.SetEventProfiles,
    "attach": act.Attach,
    "detach": act.Detach,
}


def read(told: object) -> Asked:
    """Return the actions that a process reports; none where it reports nothing.

    Raises:
        Malformed: They cannot be read.
    """
    if told is None:
        return {}
    if not isinstance(told, Mapping):
        raise Malformed("what was asked of components is no table")
    return {str(instance): _actions(str(instance), each) for instance, each in told.items()}


def _actions(instance: str, told: object) -> tuple[Action, ...]:
    if not isinstance(told, list):
        raise Malformed(f"what was asked of {instance} is no list")
    return tuple(_action(instance, message) for message in told)


def _action(instance: str, message: object) -> Action:
    if not isinstance(message, Mapping) or message.get("op") not in _ACTIONS:
        raise Malformed(f"unknown request of {instance}")
    cls = _ACTIONS[message["op"]]
    whose = "owner" if issubclass(cls, (act.Attach, act.Detach)) else "instance"
    rest = {name: value for name, value in message.items() if name != "op"}
    return decode(cls, {**rest, whose: instance})


def desired(instance: str, actions: Iterable[Action]) -> DesiredComponent:
    """Return what these actions come to, of a component of which nothing else is known."""
    kept = DesiredState()
    kept.components[instance] = DesiredComponent("")
    for action in actions:
        note(kept, action)
    return kept.components[instance]
