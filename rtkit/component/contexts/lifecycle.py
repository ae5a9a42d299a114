"""The life cycle of a component as a table: state, event, next state.

This module has all transitions; `rtkit.component.contexts.context` runs the callbacks.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from rtkit.rtc.enums import LifeCycleState, Transition

CREATED = LifeCycleState.CREATED
INACTIVE = LifeCycleState.INACTIVE
ACTIVE = LifeCycleState.ACTIVE
ERROR = LifeCycleState.ERROR


class LifeCycleEvent(StrEnum):
    """Event in the life of a component in one execution context."""

    INITIALIZE = "initialize"
    ACTIVATE = "activate"
    DEACTIVATE = "deactivate"
    FAIL = "fail"
    RESET = "reset"
    FINALIZE = "finalize"


TABLE: Mapping[LifeCycleState, Mapping[LifeCycleEvent, LifeCycleState]] = {
    CREATED: {LifeCycleEvent.INITIALIZE: INACTIVE},
    INACTIVE: {
        LifeCycleEvent.ACTIVATE: ACTIVE,
        LifeCycleEvent.FAIL: ERROR,
        LifeCycleEvent.FINALIZE: CREATED,
    },
    ACTIVE: {LifeCycleEvent.DEACTIVATE: INACTIVE, LifeCycleEvent.FAIL: ERROR},
    ERROR: {LifeCycleEvent.RESET: INACTIVE, LifeCycleEvent.FINALIZE: CREATED},
}
"""The transitions that exist; an event that a state does not list is refused."""

CALLBACK: Mapping[LifeCycleEvent, str] = {
    LifeCycleEvent.ACTIVATE: "on_activated",
    LifeCycleEvent.DEACTIVATE: "on_deactivated",
    LifeCycleEvent.FAIL: "on_aborting",
    LifeCycleEvent.RESET: "on_reset",
}
"""The callback that a transition runs."""

TARGET: Mapping[Transition, LifeCycleState] = {
    Transition.ACTIVATE: ACTIVE,
    Transition.DEACTIVATE: INACTIVE,
    Transition.RESET: INACTIVE,
}
"""Target state of each request; a component already in that state has fulfilled it."""


def next_state(state: LifeCycleState, event: LifeCycleEvent) -> LifeCycleState | None:
    """Return the state after `event`, None when it cannot happen in `state`."""
    return TABLE[state].get(event)


def refusal(state: LifeCycleState) -> str:
    """Return the message for a request that `state` does not allow."""
    return f"precondition not met (state is {state})"
