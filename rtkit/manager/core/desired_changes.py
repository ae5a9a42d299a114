"""Records in the desired state what follows from actions, done here or reported by a process.

See decision 41.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.errors import Malformed
from rtkit.fast_dataclass import replace
from rtkit.manager.core.desired import DesiredComponent, DesiredState, module_row
from rtkit.rtc.enums import Transition
from rtkit.rtc.serde import decode


def note(kept: DesiredState, action: Action) -> None:
    """Record an action that was done, but for those on whole components, which say more."""
    match action:
        case act.Load(path, init):
            kept.put("module", module_row(path, init), init)
        case act.Connect(connector):
            whole = replace(connector, trouble="") if connector.trouble else connector
            kept.put("wire", connector.connector_id, whole)
        case act.ActivateSet(instance, set_id):
            kept.change(instance, active_set=set_id)
        case act.SetStructure(instance, states):
            kept.change(instance, states=states)
        case act.SetEventProfiles(instance, events):
            kept.change(instance, events=events)
        case act.Attach(owner) | act.Detach(owner):
            _attach(kept, kept.components.get(owner, _NONE), action)
        case act.RemoveSet(instance, set_id):
            sets = kept.components.get(instance, _NONE).sets
            kept.change(instance, sets={k: v for k, v in sets.items() if k != set_id})
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

OPERATIONS: Mapping[type[Action], str] = {
    act.SetParameters: "set",
    act.RemoveSet: "remove_set",
    act.ActivateSet: "activate_set",
    act.ChangeState: "change_state",
    act.SetRate: "set_rate",
    act.SetContext: "set_context",
    act.Tick: "tick",
    act.SetStructure: "set_structure",
    act.SetEventProfiles: "set_events",
    act.Attach: "attach",
    act.Detach: "detach",
}
"""By which operation of a container an action is done."""
_ACTIONS: Mapping[object, type[Action]] = {op: kind for kind, op in OPERATIONS.items()}


def requests_from(reported: object) -> Asked:
    """Return the actions that a process reports; none where it reports nothing.

    Raises:
        Malformed: They cannot be read.
    """
    if reported is None:
        return {}
    if not isinstance(reported, Mapping):
        raise Malformed("what was asked of components is no table")
    return {str(instance): _actions(str(instance), each) for instance, each in reported.items()}


def _actions(instance: str, reported: object) -> tuple[Action, ...]:
    if not isinstance(reported, list):
        raise Malformed(f"what was asked of {instance} is no list")
    return tuple(_action(instance, message) for message in reported)


def _action(instance: str, message: object) -> Action:
    if not isinstance(message, Mapping) or message.get("op") not in _ACTIONS:
        raise Malformed(f"unknown request of {instance}")
    cls = _ACTIONS[message["op"]]
    whose = "owner" if issubclass(cls, (act.Attach, act.Detach)) else "instance"
    rest = {name: value for name, value in message.items() if name != "op"}
    return decode(cls, {**rest, whose: instance})


def desired_by(instance: str, actions: Iterable[Action]) -> DesiredComponent:
    """Return what these actions come to, of a component of which nothing else is known."""
    kept = DesiredState()
    kept.components[instance] = DesiredComponent("")
    for action in actions:
        note(kept, action)
    return kept.components[instance]
