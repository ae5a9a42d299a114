"""What was done about ends is told, and the next manager goes on where this one was."""

from __future__ import annotations

import pytest
from endings import come_back, do, heir, in_error, make, pass_time, restore
from fake_shell import FakeShell, facts

from rtkit.deployment import actions as act
from rtkit.deployment.delta import TREE, Delta, FullSnapshot, applied, delta_between
from rtkit.deployment.facts import RestartStatus
from rtkit.deployment.user_events import SUPERVISION, UserEvent, user_events
from rtkit.manager.core import events as ev
from rtkit.property.exchange import Reply
from rtkit.rtc.enums import LifeCycleState, Transition
from rtkit.rtc.serde import decode, decode_text


def restart_status(shell: FakeShell, instance: str = "A") -> RestartStatus:
    return shell.state.components[instance].restart_status


def listen(shell: FakeShell, monkeypatch: pytest.MonkeyPatch) -> list[UserEvent]:
    """Return a list to which everything is added that happens from now on."""
    heard: list[UserEvent] = []
    replies: list[Reply] = []
    shell.feed(ev.SnapshotRequested(shell.requests.add(replies.append)))
    known = decode_text(FullSnapshot, replies[0].value()).facts
    carry_out = shell._carry_out

    def hear(instruction: ev.Instruction) -> None:
        nonlocal known
        if isinstance(instruction, ev.Publish) and instruction.line == TREE:
            delta = decode(Delta, instruction.message)
            heard.extend(user_events(known, delta))
            known = applied(known, delta)
        carry_out(instruction)

    monkeypatch.setattr(shell, "_carry_out", hear)
    return heard


def found(shell: FakeShell, name: str = "s", instance: str = "A") -> int:
    """Have the slave of an earlier manager say what it holds; return its key."""
    held = {**facts(instance), "create": f"Thing?instance_name={instance}&manager_name={name}"}
    shell.feed(ev.SlaveFound(900, name, [held], []))
    return shell.adopted[900]


def test_what_was_made_again_is_told_to_the_next_manager(shell: FakeShell) -> None:
    make(shell, "A", restart="on-failure")
    for _ in range(2):
        shell.end(shell.state.containers["A"])
        come_back(shell)
    before = restart_status(shell)
    assert (before.restarts, before.why, before.returning) == (2, "signal 9", "")
    assert before.took_s == pytest.approx(0.2, rel=0.2)
    other = heir(shell)
    found(other)
    restore(other)
    assert restart_status(other) == before
    assert other.state.kept.watched == shell.state.kept.watched


def test_who_dies_at_every_start_is_not_made_again_more_often_by_many_managers(
    shell: FakeShell,
) -> None:
    """Each manager dies while it waits, or just after it has made it again."""
    make(shell, "A", restart="on-failure")
    starts, began = [], shell.now
    shell.end(shell.state.containers["A"])
    for turn in range(20):
        shell = heir(shell)
        restore(shell)
        if turn % 2:
            continue  # killed while it waits
        pass_time(shell, 20.0)
        if "s" in shell.spawned:
            starts.append(shell.now - began)
            shell.fork("s")
            shell.serve()
            shell.end(shell.state.containers["A"])
    assert len(starts) == 5
    waits = [later - sooner for sooner, later in zip([0.0, *starts], starts, strict=False)]
    assert waits == [pytest.approx(0.1 * 2**n, rel=0.11) for n in range(5)]
    assert restart_status(shell).given_up == "given up after 5 restarts within 60 s"
    assert "given up after 5" in shell.state.components["A"].zombie


def test_who_was_to_come_back_does_under_the_next_manager_and_is_shown_meanwhile(
    shell: FakeShell,
) -> None:
    make(shell, "A", **{"restart": "always", "restart.delay": "8"})
    make(shell, "B", "t")
    shell.end(shell.state.containers["A"])
    shell.wait(2.0)
    other = heir(shell)
    assert other.state.components["A"].zombie == "signal 9"
    assert restart_status(other).returning == "signal 9"
    restore(other)
    assert (other.state.components["A"].zombie, "B" in other.state.components) == ("signal 9", True)
    began = other.now
    come_back(other)
    assert other.now - began == pytest.approx(6.0, abs=0.9)
    assert (other.state.components["A"].zombie, restart_status(other).restarts) == ("", 1)


def test_who_died_while_there_was_no_manager_is_made_again_as_its_policy_says(
    shell: FakeShell,
) -> None:
    for instance, policy in (("A", "on-failure"), ("B", "never")):
        make(shell, instance, **{"restart": policy})
    other = heir(shell)
    other.feed(ev.SlaveExitedUnseen(900, "s", [facts("A"), facts("B")], "signal 11"))
    restore(other)
    assert other.state.components["A"].zombie == "signal 11"
    assert come_back(other) == ["create"]
    assert (restart_status(other).why, restart_status(other).restarts) == ("signal 11", 1)
    assert other.state.components["B"].zombie == "signal 11"


@pytest.mark.parametrize("managers", [1, 2, 3])
def test_managers_that_are_killed_in_their_start_forget_no_policy(
    managers: int, shell: FakeShell
) -> None:
    """That it died and that it is to come back are in one commit; it counts as one end."""
    make(shell, "A", restart="on-failure")
    shell = heir(shell)
    shell.feed(ev.SlaveExitedUnseen(900, "s", [facts("A")], "signal 9"))
    for _ in range(managers):
        assert {("zombie", "A"), ("watched", "A")} <= shell.rows.keys()
        shell = heir(shell)
    assert restart_status(shell).returning == "signal 9"
    restore(shell)
    assert come_back(shell) == ["create"]
    assert (restart_status(shell).why, restart_status(shell).restarts) == ("signal 9", 1)
    assert len(shell.state.watched("A").ledger.times) == 1


def test_who_died_with_everything_or_with_the_machine_begins_anew() -> None:
    shell = heir(FakeShell(), "one run")
    restore(shell)
    make(shell, "A", restart="on-failure")
    for _ in range(6):
        shell.end(shell.state.containers["A"])
        come_back(shell)
    assert restart_status(shell).given_up
    other = heir(shell, "one run")
    restore(other)
    assert "given up" in other.state.components["A"].zombie
    other = heir(shell, "another run")
    restore(other)
    told = other.state.components["A"]
    assert (told.zombie, restart_status(other).given_up, restart_status(other).restarts) == (
        "",
        "",
        5,
    )
    other.end(other.state.containers["A"])
    assert come_back(other) == ["create"]


def test_one_found_in_error_is_answered_once(shell: FakeShell) -> None:
    make(shell, "A", **{"restart": "on-failure", "restart.limit": "1"})
    for _ in range(2):
        held = {**in_error("A"), "create": "Thing?instance_name=A&manager_name=s"}
        shell = heir(shell)
        shell.feed(ev.SlaveFound(900, "s", [held], []))
        restore(shell)
        come_back(shell)
    assert restart_status(shell).given_up
    assert restart_status(shell).restarts == 1


def test_what_is_reset_keeps_its_record_and_is_forgiven(shell: FakeShell) -> None:
    key = make(shell, "A", **{"restart": "on-failure", "restart.limit": "1"})
    for _ in range(2):
        shell.say(key, facts=in_error("A"))
        come_back(shell, 1.0)
    assert restart_status(shell).trouble == "given up after 1 restarts within 60 s"
    do(shell, act.ChangeState("A", "0", Transition.RESET))
    assert (restart_status(shell).restarts, restart_status(shell).trouble) == (1, "")


def test_one_that_is_reset_while_it_waits_is_left(shell: FakeShell) -> None:
    key = make(shell, "A", restart="on-failure")
    shell.say(key, facts=in_error("A"))
    do(shell, act.ChangeState("A", "0", Transition.RESET))
    shell.say(key, facts=facts("A"))
    assert come_back(shell, 10.0) == []
    assert restart_status(shell) == RestartStatus()


def test_what_is_critical_says_what_it_stopped_until_it_is_activated(shell: FakeShell) -> None:
    make(shell, "A", "t")
    key = make(shell, "C", critical="yes", restart="on-failure")
    for instance in "AC":
        active = in_error(instance, LifeCycleState.ACTIVE)
        shell.say(shell.state.containers[instance], facts={**active, "cause": ""})
    shell.end(key)
    shell.serve()
    come_back(shell)
    assert restart_status(shell, "C").stops == "all was deactivated: signal 9"
    other = heir(shell)
    found(other, "s", "C")
    restore(other)
    assert restart_status(other, "C").stops == "all was deactivated: signal 9"
    do(other, act.ChangeState("C", "0", Transition.ACTIVATE))
    assert restart_status(other, "C").stops == ""


def test_the_end_is_on_the_disk_before_the_restart(shell: FakeShell) -> None:
    make(shell, "A", restart="on-failure")
    shell.end(shell.state.containers["A"])
    assert '"pending":"signal 9"' in shell.rows["watched", "A"]
    assert not shell.spawned


def test_a_disk_that_takes_nothing_holds_up_no_restart(shell: FakeShell) -> None:
    make(shell, "A", restart="on-failure")
    shell.disk = "full"
    shell.end(shell.state.containers["A"])
    assert come_back(shell) == ["create"]
    shell.disk = ""
    make(shell, "B", "t")
    assert '"restarts":1' in shell.rows["watched", "A"]


def test_what_is_no_wish_any_more_is_not_remembered(shell: FakeShell) -> None:
    key = make(shell, "A", restart="on-failure")
    shell.end(key)
    come_back(shell)
    shell.ask(act.Delete("A"))
    shell.serve()
    shell.end(shell.spawned.get("s", key), "exit status 0")
    assert not [name for name in shell.rows if name[0] == "watched"]


@pytest.mark.parametrize("end", ["signal 9", "in Error: ValueError: no (a.py:1)"])
def test_each_restart_is_told_once(
    end: str, monkeypatch: pytest.MonkeyPatch, shell: FakeShell
) -> None:
    """Also of one that is made again in its place, which is gone meanwhile."""
    make(shell, "A", restart="on-failure")
    heard = listen(shell, monkeypatch)
    key = shell.state.containers["A"]
    if end == "signal 9":
        shell.end(key)
    else:
        shell.say(key, facts=in_error("A"))
    come_back(shell)
    events = [each.event for each in heard if each.kind == SUPERVISION]
    assert events == ["RETURNING", "MADE_AGAIN"]


def test_nothing_seems_to_have_ended_that_outlived_its_manager(shell: FakeShell) -> None:
    """Whoever asks meanwhile what there is, is answered when all are back."""
    pid = shell.state.processes[make(shell, "A", restart="on-failure")].pid
    before = shell.state.snapshot()
    other = heir(shell)
    replies: list[Reply] = []
    other.feed(ev.SnapshotRequested(other.requests.add(replies.append)))
    assert not replies
    held = {**facts("A"), "create": before.components[0].create, "names": ["localhost/A.rtc"]}
    other.feed(ev.SlaveFound(pid, "s", [held], []))
    restore(other)
    (reply,) = replies
    after = decode_text(FullSnapshot, reply.value()).facts
    assert list(user_events(before, delta_between(before, after, "", 1))) == []
