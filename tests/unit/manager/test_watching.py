"""A manager tells when states are no longer what a client knows."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import pytest

from rtkit.deployment.watch import Watch, Watched, states_from_text, watch_to_text
from rtkit.errors import Malformed, Refused
from rtkit.manager.core import events as ev
from rtkit.manager.fake import FakeShell, facts
from rtkit.manager.requests import Desk
from rtkit.property.exchange import Reply, Request


@pytest.fixture
def shell() -> FakeShell:
    shell = FakeShell()
    shell.make("A")
    shell.make("B", "s")
    return shell


def ask(
    shell: FakeShell, *instances: str, known: Sequence[str] = (), timeout_s: float = 5.0
) -> Any:
    """Hand in a watch and return the list in which its answer will be."""
    replies: list[Reply] = []
    watch = Watch(tuple(Watched(each, "0") for each in instances), tuple(known), timeout_s)
    shell.feed(ev.WatchAsked(watch, replies.append))
    return replies


def states(replies: list[Reply]) -> tuple[str, ...]:
    (reply,) = replies
    return states_from_text(reply.value())


def say_state(shell: FakeShell, instance: str, state: str) -> None:
    report = facts(instance)
    report["contexts"][0]["state"] = state
    shell.say(shell.state.holders[instance], facts=report)


def test_what_differs_is_told_at_once(shell: FakeShell) -> None:
    assert states(ask(shell, "A", "No")) == ("Inactive", "missing")
    assert states(ask(shell, "A", known=["Active"])) == ("Inactive",)


def test_what_is_known_is_told_when_it_changes(shell: FakeShell) -> None:
    replies = ask(shell, "A", "B", known=["Inactive", "Inactive"])
    say_state(shell, "A", "Inactive")
    assert replies == []
    say_state(shell, "B", "Active")
    assert states(replies) == ("Inactive", "Active")
    say_state(shell, "B", "Error")
    assert len(replies) == 1


def test_a_death_is_a_change(shell: FakeShell) -> None:
    replies = ask(shell, "B", known=["Inactive"])
    shell.end(shell.state.holders["B"], "signal 9")
    assert states(replies) == ("zombie (signal 9)",)


def test_a_birth_is_a_change(shell: FakeShell) -> None:
    replies = ask(shell, "C", known=["missing"])
    shell.make("C")
    assert states(replies) == ("Inactive",)


def test_when_the_time_is_up_it_is_told_as_it_is(shell: FakeShell) -> None:
    first = ask(shell, "A", known=["Inactive"], timeout_s=5.0)
    second = ask(shell, "B", known=["Inactive"], timeout_s=2.0)
    shell.wait(2.0)
    assert (len(first), states(second)) == (0, ("Inactive",))
    shell.wait(2.9)
    assert first == []
    shell.wait(0.1)
    assert states(first) == ("Inactive",)
    assert shell.wake_at is None


def test_without_time_it_is_a_look(shell: FakeShell) -> None:
    assert states(ask(shell, "A", known=["Inactive"], timeout_s=0.0)) == ("Inactive",)


def test_nobody_is_left_waiting_at_the_end(shell: FakeShell) -> None:
    replies = ask(shell, "A", known=["Inactive"])
    shell.stop()
    late = ask(shell, "A")
    for (reply,) in (replies, late):
        with pytest.raises(Refused, match="the manager is stopping"):
            reply.value()


def test_the_desk_takes_it() -> None:
    shell = FakeShell()
    desk = Desk(shell.state)
    text = watch_to_text(Watch((Watched("A", "0"),), ("Active",), 1.5))
    event = desk.take(Request("watch", text, lambda _: None))
    assert isinstance(event, ev.WatchAsked)
    assert event.watch == Watch((Watched("A", "0"),), ("Active",), 1.5)
    with pytest.raises(Malformed):
        desk.take(Request("watch", json.dumps({"targets": "A"}), lambda _: None))
