"""The life cycle of a component as a table: state, event, next state.

All transitions are here; who runs the callbacks, and when, is said in `rtkit.component.context`.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from rtkit.rtc.enums import LifeCycleState, Transition

CREATED = LifeCycleState.CREATED
INACTIVE = LifeCycleState.INACTIVE
ACTIVE = LifeCycleState.ACTIVE
ERROR = LifeCycleState.ERROR


class Event(StrEnum):
    """What can happen to a component in one execution context."""

    INITIALIZE = "initialize"
    ACTIVATE = "activate"
    DEACTIVATE = "deactivate"
    FAIL = "fail"
    RESET = "reset"
    FINALIZE = "finalize"


TABLE: Mapping[LifeCycleState, Mapping[Event, LifeCycleState]] = {
    CREATED: {Event.INITIALIZE: INACTIVE},
    INACTIVE: {Event.ACTIVATE: ACTIVE, Event.FAIL: ERROR, Event.FINALIZE: CREATED},
    ACTIVE: {Event.DEACTIVATE: INACTIVE, Event.FAIL: ERROR},
    ERROR: {Event.RESET: INACTIVE, Event.FINALIZE: CREATED},
}
"""The transitions that exist; an event that a state does not list is refused."""

CALLBACK: Mapping[Event, str] = {
    Event.ACTIVATE: "on_activated",
    Event.DEACTIVATE: "on_deactivated",
    Event.FAIL: "on_aborting",
    Event.RESET: "on_reset",
}
"""The callback that a transition runs."""

TARGET: Mapping[Transition, LifeCycleState] = {
    Transition.ACTIVATE: ACTIVE,
    Transition.DEACTIVATE: INACTIVE,
    Transition.RESET: INACTIVE,
}
"""Where a request leads; a component already there has fulfilled it."""


def next_state(state: LifeCycleState, event: Event) -> LifeCycleState | None:
    """Return the state after `event`, None when it cannot happen in `state`."""
    return TABLE[state].get(event)


def refusal(state: LifeCycleState) -> str:
    """Return the message for a request that `state` does not allow."""
    return f"precondition not met (state is {state})"
