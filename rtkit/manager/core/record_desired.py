"""Records the changes of desired state that follow from actions that succeeded."""

from __future__ import annotations

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.manager.core.desired import MODULE, WIRE, DesiredComponent, DesiredState, module_row
from rtkit.rtc.enums import Transition


def note(kept: DesiredState, action: Action) -> None:
    """Record an action that was done, but for those on whole components, which say more."""
    match action:
        case act.Load(path, init):
            kept.put(MODULE, module_row(path, init), init)
        case act.Connect(wire):
            kept.wire(wire)
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
