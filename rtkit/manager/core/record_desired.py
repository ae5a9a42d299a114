"""Records the changes of desired state that follow from actions, done here or told by a process.

What a process was asked last is desired, recorded or not; what is desired and was not asked since a
component was made is still to be done.

See decision 41.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.errors import Malformed
from rtkit.manager.core.desired import MODULE, WIRE, DesiredComponent, DesiredState, module_row
from rtkit.rtc.enums import Transition
from rtkit.rtc.serde import decode


def note(kept: DesiredState, action: Action) -> None:
    """Record an action that was done, but for those on whole components, which say more."""
    match action:
        case act.Load(path, init):
            kept.put(MODULE, module_row(path, init), init)
        case act.Connect(connector):
            kept.wire(connector)
        case act.Disconnect(connector_id):
            kept.drop(WIRE, connector_id)
        case act.ActivateSet(instance, set_id):
            kept.change(instance, active_set=set_id)
        case act.SetStructure(instance, states):
            kept.change(instance, states=states)
        case act.SetEventProfiles(instance, events):
            kept.change(instance, events=events)
        case act.Attach(owner) | act.Detach(owner):
            _attach(kept, kept.components.get(owner, _NONE), action)
        case act.SetParameters(instance) | act.ChangeState(instance) | act.SetRate(instance):
            _set(kept, kept.components.get(instance, _NONE), action)


_NONE = DesiredComponent("")


def _set(
    kept: DesiredState,
    entry: DesiredComponent,
    action: act.SetParameters | act.ChangeState | act.SetRate,
) -> None:
    match action:
        case act.SetParameters(instance, set_id, values):
            changed = {**entry.sets.get(set_id, {}), **values}
            kept.change(instance, sets={**entry.sets, set_id: changed})
        case act.SetRate(instance, context, rate):
            kept.change(instance, rates={**entry.rates, context: rate})
        case act.ChangeState(instance, context, Transition.ACTIVATE):
            kept.change(instance, active=tuple(dict.fromkeys((*entry.active, context))))
        case act.ChangeState(instance, context):
            kept.change(instance, active=tuple(each for each in entry.active if each != context))


def _attach(kept: DesiredState, entry: DesiredComponent, action: act.Attach | act.Detach) -> None:
    driven = dict.fromkeys(entry.attached.get(action.context, ()))
    if isinstance(action, act.Attach):
        driven[action.participant] = None
    else:
        driven.pop(action.participant, None)
    kept.change(action.owner, attached={**entry.attached, action.context: tuple(driven)})


# what users asked of components since their creation, as their process reports it

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
