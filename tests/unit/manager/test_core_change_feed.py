"""What a manager tells those who listen, and what that costs it."""

from __future__ import annotations

from typing import Any

import pytest
from fake_shell import OWN, FakeShell, facts

from rtkit.deployment.delta import TREE, Delta, FullSnapshot
from rtkit.deployment.metrics import METRICS, Metrics
from rtkit.manager.core import events as ev
from rtkit.property.exchange import Reply
from rtkit.rtc.serde import decode, decode_text


class Listener:
    """Hears what a fake shell publishes."""

    def __init__(self, shell: FakeShell, monkeypatch: pytest.MonkeyPatch) -> None:
        self.shell = shell
        self.messages: list[tuple[str, Any]] = []
        carry_out = shell._carry_out

        def hear(instruction: ev.Instruction) -> None:
            if isinstance(instruction, ev.Publish):
                self.messages.append((instruction.line, instruction.message))
            carry_out(instruction)

        monkeypatch.setattr(shell, "_carry_out", hear)

    def full_snapshot(self) -> FullSnapshot:
        replies: list[Reply] = []
        self.shell.feed(ev.SnapshotRequested(self.shell.requests.add(replies.append)))
        return decode_text(FullSnapshot, replies[0].value())

    def delta(self) -> list[Delta]:
        told = [decode(Delta, message) for line, message in self.messages if line == TREE]
        self.messages.clear()
        return told

    def metrics(self) -> list[Metrics]:
        told = [decode(Metrics, message) for line, message in self.messages if line == METRICS]
        self.messages.clear()
        return told


@pytest.fixture
def listener(shell: FakeShell, monkeypatch: pytest.MonkeyPatch) -> Listener:
    return Listener(shell, monkeypatch)


def test_nothing_is_told_while_nobody_listens(shell: FakeShell, listener: Listener) -> None:
    shell.make("A")
    assert listener.messages == []
    snapshot = listener.full_snapshot()
    assert [each.instance for each in snapshot.facts.components] == ["A"]
    (ping,) = listener.delta()[-1:]
    assert (ping.run, ping.number) == (snapshot.run, snapshot.number)
    shell.feed(ev.ListenersChanged(TREE, False))
    shell.make("B")
    assert listener.messages == []


def test_news_follow_the_picture_number_by_number(shell: FakeShell, listener: Listener) -> None:
    snapshot = listener.full_snapshot()
    listener.delta()
    shell.make("A", "slave")
    told = listener.delta()
    numbers = [each.number for each in told]
    assert numbers == list(range(snapshot.number + 1, snapshot.number + 1 + len(told)))
    assert [process.state for each in told for process in each.processes] == ["starting", "up"]
    # It appears once, with its names: not while it is being made.
    (made,) = (component for each in told for component in each.components)
    assert made.names == ("localhost/A.rtc",)
    shell.feed(ev.TimerExpired())
    assert listener.delta() == []


def test_an_older_listener_sees_a_gap(shell: FakeShell, listener: Listener) -> None:
    first = listener.full_snapshot()
    shell.feed(ev.ListenersChanged(TREE, False))
    listener.delta()
    shell.make("A")
    shell.feed(ev.ListenersChanged(TREE, True))
    (ping,) = listener.delta()
    assert ping.number > first.number + 1


def test_the_end_is_told(shell: FakeShell, listener: Listener) -> None:
    listener.full_snapshot()
    shell.stop()
    shell.serve()
    assert shell.is_finished
    assert [each.is_last for each in listener.delta()][-1]


def report(instance: str) -> dict[str, Any]:
    return {"instance": instance, "written": {"out": 3}}


def test_figures_are_asked_for_only_while_wanted(shell: FakeShell, listener: Listener) -> None:
    shell.make("A")
    shell.wait(5.0)
    assert shell.told == []
    shell.feed(ev.ListenersChanged(METRICS, True))
    assert shell.told == [(OWN, {"op": "metrics"})]
    assert listener.metrics() == []
    shell.say(OWN, metrics=[report("A")])
    (metrics,) = listener.metrics()
    (process,) = metrics.processes
    assert (process.answered, process.components[0].written) == (True, {"out": 3})
    shell.wait(1.0)
    assert len(shell.told) == 2
    shell.feed(ev.ListenersChanged(METRICS, False))
    shell.wait(5.0)
    assert len(shell.told) == 2


def test_who_does_not_answer_is_told_of_and_not_asked_again(
    shell: FakeShell, listener: Listener
) -> None:
    key = shell.make("A", "slave")
    shell.feed(ev.ListenersChanged(METRICS, True))
    for count in (1, 2, 3):
        shell.say(OWN, metrics=[])
        shell.wait(1.0)
        assert [each for each in shell.told if each[0] == key] == [(key, {"op": "metrics"})]
        told = listener.metrics()
        assert told[-1].number == count
        assert [each.answered for each in told[-1].processes] == [True, False]
    shell.say(key, metrics=[report("A")])
    shell.say(OWN, metrics=[])
    shell.wait(1.0)
    assert len([each for each in shell.told if each[0] == key]) == 2


def test_figures_that_are_none_change_nothing(shell: FakeShell, listener: Listener) -> None:
    shell.make("A")
    shell.feed(ev.ListenersChanged(METRICS, True))
    with pytest.raises(ValueError, match="metrics"):
        shell.say(OWN, metrics="many")
    shell.wait(2.0)
    assert len(listener.metrics()) >= 1


def test_what_a_user_makes_again_is_no_restart(shell: FakeShell) -> None:
    key = shell.make("A", "slave")
    shell.say(key, facts=facts("A"))
    assert shell.state.components["A"].restart_status.restarts == 0
    shell.end(key)
    shell.make("A", "slave")
    assert shell.state.components["A"].restart_status.restarts == 0
