"""The table of the life cycle."""

from __future__ import annotations

import pytest

from rtkit.component.lifecycle import CALLBACK, TABLE, TARGET, Event, next_state, refusal
from rtkit.rtc.enums import LifeCycleState, Transition

C, I, A, E = LifeCycleState  # noqa: E741


@pytest.mark.parametrize(
    ("state", "event", "target"),
    [
        (C, Event.INITIALIZE, I),
        (I, Event.ACTIVATE, A),
        (A, Event.DEACTIVATE, I),
        (A, Event.FAIL, E),
        (E, Event.RESET, I),
        (A, Event.RESET, None),
        (E, Event.ACTIVATE, None),
        (E, Event.DEACTIVATE, None),
        (C, Event.ACTIVATE, None),
        (I, Event.RESET, None),
        (A, Event.FINALIZE, None),
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
        event = Event(transition.value)
        assert event in CALLBACK
        assert {row[event] for row in TABLE.values() if event in row} == {TARGET[transition]}


def test_the_message_names_the_state():
    assert refusal(A) == "precondition not met (state is Active)"
