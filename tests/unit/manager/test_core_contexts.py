"""The core hands on what clients ask of execution contexts, and to one process only."""

from __future__ import annotations

import pytest

from rtkit.deployment.actions import (
    Attach,
    ChangeState,
    Detach,
    SetContext,
    SetEventProfiles,
    SetRate,
    SetStructure,
    Tick,
)
from rtkit.deployment.batch import Batch, batch_from_text, batch_to_text
from rtkit.rtc.enums import Transition


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (
            SetContext("A", "0", {"priority": "9"}),
            {"op": "set_context", "context": "0", "settings": {"priority": "9"}},
        ),
        (SetRate("A", "0", 5.0), {"op": "set_rate", "context": "0", "rate": 5.0}),
        (Tick("A", "x"), {"op": "tick", "context": "x"}),
        (
            SetStructure("A", {"On": {"go": "On"}}),
            {"op": "set_structure", "states": {"On": {"go": "On"}}},
        ),
        (
            SetEventProfiles("A", {"go": "TimedLong"}),
            {"op": "set_events", "events": {"go": "TimedLong"}},
        ),
        (Attach("A", "0", "B"), {"op": "attach", "context": "0", "participant": "B"}),
        (Detach("A", "0", "B"), {"op": "detach", "context": "0", "participant": "B"}),
    ],
)
def test_each_is_one_message_to_the_process_of_the_context(shell, action, message):
    key = shell.make("A", "s")
    shell.make("B", "s")
    assert batch_from_text(batch_to_text(Batch((action,)))).actions == (action,)
    asked = shell.ask(action)
    call = shell.next(message["op"])
    assert call.key == key
    assert {k: v for k, v in call.message.items() if k not in ("call", "until")} == {
        **message,
        "instance": "A",
    }
    shell.reply(call)
    assert asked.result.ok


@pytest.mark.parametrize("kind", [Attach, Detach])
def test_participants_are_of_the_same_process(shell, kind):
    shell.make("A", "s")
    shell.make("B", "t")
    asked = shell.ask(kind("A", "0", "B"))
    assert not shell.calls
    assert asked.result.kind == "refused"
    assert asked.result.why == (
        "B is in t, A in s: an execution context drives components of its own process only"
    )


@pytest.mark.parametrize("kind", [Attach, Detach])
def test_both_must_exist(shell, kind):
    shell.make("A")
    for action in (kind("A", "0", "No"), kind("No", "0", "A")):
        assert shell.ask(action).result.why == "no component named No"


def test_what_failed_at_a_transition_that_was_done_is_told(shell):
    shell.make("A", "s")
    asked = shell.ask(ChangeState("A", "0", Transition.DEACTIVATE))
    shell.reply(shell.next("change_state"), "on_deactivated failed: ValueError: no")
    assert asked.result.ok
    assert asked.result.note == "on_deactivated failed: ValueError: no"
