"""Questions what ports carry: which processes are asked, and what of one that does not answer."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any, cast

import pytest

from rtkit.errors import Malformed
from rtkit.manager import port_sampler
from rtkit.manager.core.state import ManagerState
from rtkit.manager.port_sampler import PortSampler
from rtkit.property.exchange import Reply, Request


class Asked:
    """A sampler of two processes, each with one component."""

    def __init__(self) -> None:
        self.sent: list[tuple[int, Any]] = []
        self.replies: list[Reply] = []
        up = {key: SimpleNamespace(state="up") for key in (1, 2)}
        state = SimpleNamespace(containers={"A": 1, "B": 2}, processes=up)
        self.sampler = PortSampler(
            cast(ManagerState, state), lambda key, message: self.sent.append((key, message))
        )

    def ask(self, *ports: tuple[str, str]) -> None:
        self.sampler.ask(Request("samples", json.dumps(ports), self.replies.append, True))

    def answer(self, number: int) -> None:
        key, message = self.sent[number]
        samples = [[*port, {"count": key}] for port in message["ports"]]
        self.sampler.take(key, {"samples": samples, "number": message["number"]})


def test_each_process_is_asked_for_its_own_ports_and_one_answer_has_all() -> None:
    asked = Asked()
    asked.ask(("A", "out"), ("B", "in"), ("C", "none"))
    assert [(key, message["ports"]) for key, message in asked.sent] == [
        (1, [("A", "out")]),
        (2, [("B", "in")]),
    ]
    asked.answer(1)
    assert not asked.replies
    asked.answer(0)
    (reply,) = asked.replies
    assert json.loads(reply.text) == [["B", "in", {"count": 2}], ["A", "out", {"count": 1}]]
    assert asked.sampler.due_at() is None


def test_a_process_that_does_not_answer_is_left_out_and_not_asked_until_it_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [0.0]
    monkeypatch.setattr(port_sampler, "monotonic", lambda: now[0])
    asked = Asked()
    asked.ask(("A", "out"), ("B", "in"))
    asked.answer(0)
    now[0] = asked.sampler.due_at() or 0.0
    asked.sampler.give_up()
    assert json.loads(asked.replies[0].text) == [["A", "out", {"count": 1}]]
    asked.ask(("B", "in"))
    assert json.loads(asked.replies[1].text) == []
    assert len(asked.sent) == 2
    asked.answer(1)  # late
    asked.ask(("B", "in"))
    assert len(asked.sent) == 3


def test_a_question_that_is_none_is_refused() -> None:
    for text in ("", "[1]", '[["A"]]', '[["A", 1]]'):
        with pytest.raises(Malformed):
            Asked().sampler.ask(Request("samples", text, lambda _reply: None, True))
