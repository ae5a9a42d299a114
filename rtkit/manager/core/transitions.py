"""Changes the states of components, and waits for that within a time limit."""

from __future__ import annotations

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.manager.core.effects import Call, Procedure
from rtkit.manager.core.state import ManagerState
from rtkit.manager.core.wiring import living
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import Transition
from rtkit.settings.properties import check

_WORD = {
    Transition.ACTIVATE: "activation",
    Transition.DEACTIVATE: "deactivation",
    Transition.RESET: "reset",
}


def change_state(state: ManagerState, action: act.ChangeState) -> Procedure:
    """Activate, deactivate or reset a component.

    Raises:
        Malformed: A property of the component that bounds it cannot be read.
    """
    process = living(state, action.instance)
    word = _WORD[action.transition]
    is_sync = _option(state, action.instance, f"exec_cxt.sync_{word}", "exec_cxt.sync_transition")
    bound = _option(
        state, action.instance, f"exec_cxt.{word}_timeout", "exec_cxt.transition_timeout"
    )
    message = {
        "op": "change_state",
        "context": action.context,
        "transition": action.transition.value,
        "wait": action.wait and is_sync != "NO",
        "instance": action.instance,
    }
    _forgive(state, action)
    told = yield Call(process, message, float(bound or 0))
    return Result(note=told if isinstance(told, str) else "")


def _forgive(state: ManagerState, action: act.ChangeState) -> None:
    """Begin anew with a component that its user resets, or activates after it was stopped."""
    watched = state.kept.watched.get(action.instance)
    if watched is None:
        return
    if action.transition is Transition.RESET:
        state.kept.put("watched", action.instance, watched.record)
    elif action.transition is Transition.ACTIVATE:
        state.kept.watch(action.instance, rested="", halted="")
    state.report_restart_status(action.instance)


def _option(state: ManagerState, instance: str, *keys: str) -> str:
    """Return the first of these properties that component or manager was given."""
    create = state.components[instance].create
    own = parse_create(create).options if create else {}
    for key in keys:
        value = check(key, own.get(key, "")) or (
            state.settings.text(key) if state.settings.is_given(key) else ""
        )
        if value:
            return value
    return ""
