"""The table of the life cycle."""

from __future__ import annotations

import pytest

from rtkit.component.contexts.lifecycle import (
    CALLBACK,
    TABLE,
    TARGET,
    LifeCycleEvent,
    next_state,
    refusal,
)
from rtkit.rtc.enums import LifeCycleState, Transition

C, I, A, E = LifeCycleState  # noqa: E741


@pytest.mark.parametrize(
    ("state", "event", "target"),
    [
        (C, LifeCycleEvent.INITIALIZE, I),
        (I, LifeCycleEvent.ACTIVATE, A),
        (A, LifeCycleEvent.DEACTIVATE, I),
        (A, LifeCycleEvent.FAIL, E),
        (E, LifeCycleEvent.RESET, I),
        (A, LifeCycleEvent.RESET, None),
        (E, LifeCycleEvent.ACTIVATE, None),
        (E, LifeCycleEvent.DEACTIVATE, None),
        (C, LifeCycleEvent.ACTIVATE, None),
        (I, LifeCycleEvent.RESET, None),
        (A, LifeCycleEvent.FINALIZE, None),
    ],
)
def test_transitions(state, event, target):
    assert next_state(state, event) is target


def test_every_state_has_a_row_and_can_be_left():
    assert set(TABLE) == set(LifeCycleState)
    for row in TABLE.values():
        assert row


def test_every_request_is_an_event_with_a_callback_and_one_target():
    for transition in Transition:
        event = LifeCycleEvent(transition.value)
        assert event in CALLBACK
        assert {row[event] for row in TABLE.values() if event in row} == {TARGET[transition]}


def test_the_message_names_the_state():
    assert refusal(A) == "precondition not met (state is Active)"
