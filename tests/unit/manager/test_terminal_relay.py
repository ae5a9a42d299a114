"""Questions to terminals on their way through a manager."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any, cast

import pytest

from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable
from rtkit.manager import terminal_relay
from rtkit.manager.core.state import ManagerState
from rtkit.manager.terminal_relay import TerminalRelay
from rtkit.property.exchange import Reply, Request


class Asked:
    """A relay with a component of each kind, and a clock."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        monkeypatch.setattr(terminal_relay, "monotonic", lambda: self.now)
        self.sent: list[tuple[int, Any]] = []
        self.replies: list[Reply] = []
        zombies = {"Lives": "", "Dead": "signal 9", "Tool": "", "Stopped": ""}
        processes = {
            1: SimpleNamespace(is_guest=False, unfit=""),
            2: SimpleNamespace(is_guest=True, unfit=""),
            3: SimpleNamespace(is_guest=False, unfit="s is stopped"),
        }
        state = SimpleNamespace(
            components={name: SimpleNamespace(zombie=why) for name, why in zombies.items()},
            containers={"Lives": 1, "Dead": 1, "Tool": 2, "Stopped": 3},
            processes=processes,
        )
        self.relay = TerminalRelay(
            cast(ManagerState, state), lambda key, message: self.sent.append((key, message))
        )

    def ask(self, instance: str = "Lives", **more: object) -> None:
        text = json.dumps({"instance": instance, **more})
        self.relay.ask(Request("terminal", text, self.replies.append, True))

    def answer(self, **state: object) -> None:
        key, message = self.sent[-1]
        self.relay.take(key, {"terminal": state, "number": message["number"]})


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Asked:
    return Asked(monkeypatch)


def test_a_question_goes_to_the_process_and_its_answer_comes_back(asked: Asked) -> None:
    asked.ask(input="5\n")
    key, message = asked.sent[0]
    assert (key, message["op"], message["input"]) == (1, "terminal", "5\n")
    asked.answer(after=7)
    assert json.loads(asked.replies[0].text) == {"after": 7}
    asked.answer(after=8)
    assert len(asked.replies) == 1


@pytest.mark.parametrize(
    ("instance", "kind", "why"),
    [
        ("Nobody", NotFound, "no component named Nobody"),
        ("Dead", NotFound, r"Dead is a zombie \(signal 9\)"),
        ("Tool", Refused, "started by hand"),
        ("Stopped", Unreachable, "s is stopped"),
    ],
)
def test_who_has_no_terminal_is_told_at_once(
    asked: Asked, instance: str, kind: type[RtkitError], why: str
) -> None:
    with pytest.raises(kind, match=why):
        asked.ask(instance)


def test_what_was_waited_for_long_enough_is_asked_for_as_it_is(asked: Asked) -> None:
    asked.ask(wait_s=5.0, input="x", size=[24, 80])
    assert asked.relay.due_at() == 105.0
    asked.now = 105.0
    asked.relay.hurry()
    again = asked.sent[1][1]
    assert (again["wait_s"], again["input"], again["size"]) == (0.0, "", [])
    asked.answer(after=1)
    assert json.loads(asked.replies[0].text) == {"after": 1}
    assert asked.relay.due_at() is None


def test_a_process_that_does_not_answer_is_given_up(asked: Asked) -> None:
    asked.ask()
    asked.now = asked.relay.due_at() or 0.0
    asked.relay.hurry()
    assert asked.replies[0].error == Unreachable.kind
    assert asked.replies[0].text == "Lives does not answer"


def test_the_end_of_a_process_answers_whoever_waits(asked: Asked) -> None:
    asked.ask(wait_s=20.0)
    asked.relay.ended(2, "signal 15")
    assert not asked.replies
    asked.relay.ended(1, "signal 9")
    assert json.loads(asked.replies[0].text) == {"ended": "signal 9"}


@pytest.mark.parametrize(
    "text",
    [
        "", "[]", "{}", '{"instance": "A", "after": "x"}', '{"instance": "A", "size": [1]}',
        '{"instance": "A", "input": "\\u0100"}', '{"instance": "A", "wait_s": NaN}',
        json.dumps({"instance": "A", "input": "x" * 40_000}), '{"instance": "A", "size": 5}',
    ],
)  # fmt: skip
def test_what_is_no_question_is_refused(asked: Asked, text: str) -> None:
    with pytest.raises(Malformed, match="no question to a terminal"):
        asked.relay.ask(Request("terminal", text, asked.replies.append, True))
