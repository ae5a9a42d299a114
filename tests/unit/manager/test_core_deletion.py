"""Ending by force: what it asks first, whom it ends, what it says of the rest."""

from __future__ import annotations

import signal

import pytest
from fake_shell import OWN, wire

from rtkit.deployment.actions import Connect, Create, Delete, EndSlave
from rtkit.manager.core import events as ev
from rtkit.manager.core.deletion import FORCE_S, TERM_S

STUCK = "stuck in on_execute since 12:00:00 (Arm.py:9 in on_execute)"
TERM, KILL, CONT = signal.SIGTERM, signal.SIGKILL, signal.SIGCONT


@pytest.fixture
def slave(shell):
    """A slave with A, which is stuck, B and C; its key."""
    for instance in "ABC":
        key = shell.make(instance, "s")
    shell.feed(ev.CallbackStuck(key, "A", STUCK))
    return key


def remarks(shell):
    return {name: facts.zombie for name, facts in shell.state.components.items()}


# without force


def test_one_of_another_process_is_not_deleted(shell, slave):
    shell.make("D", "t")
    shell.make("M")
    for instance, home in (("D", "t"), ("M", "manager")):
        asked = shell.ask(Delete(instance, slave="s"))
        why = f"no component named {instance} in s: it is in {home}"
        assert (asked.result.kind, asked.result.why) == ("not-found", why)
        assert not shell.calls
    shell.state.processes[slave].stuck.clear()
    asked = shell.ask(Delete("B", slave="s"))
    shell.serve()
    assert asked.result.ok


def test_one_that_does_not_end_is_told_with_what_helps(shell, slave):
    asked = shell.ask(Delete("A"), timeout_s=2.0)
    shell.wait(2.0)
    assert asked.result.why == (
        f"no answer from s in time: A is {STUCK};"
        " the request stays queued and is done when that returns;"
        " rtexit --force ends its slave s, and with it B, C"
    )
    assert not shell.signals
    assert shell.state.components["A"].trouble == STUCK


def test_one_in_the_manager_is_told_to_be_there(shell):
    shell.make("A")
    asked = shell.ask(Delete("A"), timeout_s=2.0)
    shell.wait(2.0)
    assert asked.result.why == (
        "no answer from manager in time; the request stays queued and is done when that returns;"
        " only rtmgr restart or rtmgr stop ends the manager's own process, which it is in"
    )


def test_one_that_ends_with_its_slave_needs_no_advice(shell, slave):
    asked = shell.ask(Delete("A"))
    shell.end(slave)
    assert asked.result.why == "slave s ended: signal 9"


def test_a_request_that_was_given_up_and_comes_through_ends_the_empty_slave(shell):
    key = shell.make("A", "s")
    asked = shell.ask(Delete("A"), timeout_s=2.0)
    shell.wait(2.0)
    assert not asked.result.ok
    shell.say(key, gone="A")
    assert not shell.state.components
    assert shell.signals == [(key, TERM)]


# by force


def test_one_that_ends_by_itself_takes_nobody_along(shell, slave):
    asked = shell.ask(Delete("A", is_forced=True))
    shell.serve()
    assert (asked.result.ok, asked.result.value) == (True, "")
    assert remarks(shell) == {"B": "", "C": ""}
    assert not shell.signals


def test_one_that_does_not_ends_with_its_slave_and_the_rest_are_zombies(shell, slave):
    shell.make("D")
    shell.ask(Connect(wire("w", "B.out", "D.in")))
    shell.serve()
    asked = shell.ask(Delete("A", is_forced=True))
    shell.wait(FORCE_S)
    assert shell.signals == [(slave, TERM)]
    shell.wait(TERM_S)
    assert shell.signals == [(slave, TERM), (slave, KILL)]
    assert not asked.is_answered
    shell.end(slave)
    assert (asked.result.ok, asked.result.value) == (True, "B,C")
    assert remarks(shell) == {"B": "ended by force, with A", "C": "ended by force, with A", "D": ""}
    assert not shell.state.connectors


def test_the_last_one_of_a_slave_leaves_nothing_behind(shell):
    key = shell.make("A", "s")
    asked = shell.ask(Delete("A", is_forced=True))
    shell.wait(FORCE_S)
    shell.end(key, "exit status 0")
    assert (asked.result.ok, asked.result.value) == (True, "")
    assert not shell.state.components
    assert [p.name for p in shell.state.processes.values()] == ["manager"]


def test_force_helps_an_earlier_request_that_still_waits(shell, slave):
    first = shell.ask(Delete("A"), timeout_s=100.0)
    second = shell.ask(Delete("A", is_forced=True))
    shell.wait(FORCE_S)
    shell.end(slave)
    assert second.result.ok
    assert first.result.why == "slave s ended: ended by force, with A"


def test_a_stopped_slave_is_ended_without_being_asked_first(shell, slave):
    shell.feed(ev.SlaveStopped(slave, True))
    shell.ask(Delete("A", is_forced=True))
    assert shell.signals == [(slave, TERM), (slave, CONT)]


def test_the_manager_s_own_process_is_never_ended(shell):
    shell.make("A")
    asked = shell.ask(Delete("A", is_forced=True))
    shell.wait(FORCE_S)
    assert asked.result.why == (
        "no answer from manager in time; it is in the manager's own process, which is not ended by"
        " force; only rtmgr restart or rtmgr stop ends it"
    )
    assert not shell.signals
    assert remarks(shell) == {"A": ""}


def test_a_guest_s_process_is_never_ended(shell):
    shell.visit(900, "tool", ["A"])
    asked = shell.ask(Delete("A", is_forced=True))
    shell.wait(FORCE_S)
    assert "it is in a guest's process, which is not ended by force" in asked.result.why
    assert not shell.signals


def test_one_that_survives_even_a_kill_is_told(shell, slave):
    asked = shell.ask(Delete("A", is_forced=True))
    shell.wait(FORCE_S + 2 * TERM_S)
    assert asked.result.why == "slave s has not ended, though it was killed"


# slaves


def test_a_slave_ends_after_all_that_it_holds_the_youngest_first(shell, slave):
    asked = shell.ask(EndSlave("s"))
    deleted = []
    while shell.calls:
        call = shell.next("delete")
        deleted.append(call.message["instance"])
        shell.say(slave, gone=deleted[-1])
        shell.reply(call)
    assert deleted == ["C", "B", "A"]
    assert shell.signals == [(slave, TERM)]
    shell.end(slave, "exit status 0")
    assert asked.result.ok
    assert not shell.state.components


def test_a_slave_that_holds_one_that_is_stuck_does_not_end(shell, slave):
    asked = shell.ask(EndSlave("s"), timeout_s=2.0)
    shell.calls.clear()
    shell.wait(2.0)
    assert asked.result.why.endswith("rtexit --force ends its slave s, and with it A, B")
    assert not shell.signals


def test_by_force_a_slave_ends_at_once_and_nothing_of_it_is_left(shell, slave):
    asked = shell.ask(EndSlave("s", is_forced=True))
    assert shell.signals == [(slave, TERM)]
    shell.wait(TERM_S)
    shell.end(slave)
    assert asked.result.ok
    assert not shell.state.components


def test_a_slave_in_which_a_creation_hangs_can_be_ended(shell, slave):
    making = shell.ask(Create("Thing?instance_name=D&manager_name=s"), timeout_s=100.0)
    asked = shell.ask(EndSlave("s", is_forced=True))
    shell.end(slave)
    assert asked.result.ok
    assert making.result.why == "slave s ended: signal 9"
    assert not shell.state.claims


def test_only_living_slaves_can_be_ended(shell, slave):
    shell.visit(900, "tool", ["D"])
    assert shell.ask(EndSlave("no")).result.kind == "not-found"
    assert "no slave" in shell.ask(EndSlave("manager", is_forced=True)).result.why
    assert "no slave" in shell.ask(EndSlave("tool", is_forced=True)).result.why
    shell.end(slave)
    assert shell.ask(EndSlave("s")).result.why == "slave s has ended already: signal 9"
    assert not shell.signals


# creations that hang


def hung(shell, place, *, timeout_s=2.0):
    """Ask for a component whose making does not end; return what is answered."""
    asked = shell.ask(Create(f"Thing?instance_name=N{place}"), timeout_s=timeout_s)
    if "s" in shell.spawned:
        shell.fork("s")
    key = shell.next("create").key
    shell.feed(ev.CallbackStuck(key, "N", STUCK))
    shell.wait(timeout_s)
    return asked.result.why, key


def test_a_slave_that_was_started_for_one_that_hangs_is_ended(shell):
    shell.state.settings.change("manager.shutdown_on_nortcs", "NO")
    why, key = hung(shell, "&manager_name=s")
    late = f"no answer from s in time: N is {STUCK}"
    assert why == f"{late}; slave s, started for it, is ended"
    assert shell.told == [(key, {"op": "delete", "instance": "N"})]
    shell.wait(TERM_S)
    assert shell.signals == [(key, TERM), (key, KILL)]
    assert [row.name for row in shell.state.snapshot().processes if row.reason]


def test_a_slave_that_was_there_before_stays_and_is_marked(shell):
    key = shell.make("A", "s")
    why, _ = hung(shell, "&manager_name=s")
    assert why.endswith(
        "; slave s makes and ends nothing else until that returns;"
        " rtexit --force /localhost/manager.mgr/s.mgr ends it"
    )
    shell.wait(100.0)
    assert not shell.signals
    (slave,) = [p for p in shell.state.snapshot().processes if p.is_slave]
    assert (slave.state, slave.reason) == ("up", f"N is {STUCK}")
    shell.feed(ev.CallbackStuck(key, "N", ""))
    (slave,) = [p for p in shell.state.snapshot().processes if p.is_slave]
    assert slave.reason == ""


def test_one_that_hangs_in_the_manager_marks_the_manager(shell):
    why, key = hung(shell, "")
    assert key == OWN
    assert why.endswith(
        "; the manager's own process makes and ends nothing else until that returns;"
        " only rtmgr restart or rtmgr stop ends it"
    )
    assert shell.state.snapshot().processes[0].reason == f"N is {STUCK}"


def test_a_slave_in_which_another_was_made_meanwhile_is_not_ended(shell):
    other = shell.ask(Create("Thing?instance_name=A&manager_name=s"))
    asked = shell.ask(Create("Thing?instance_name=N&manager_name=s"), timeout_s=2.0)
    key = shell.fork("s")
    hangs = shell.calls.pop()
    shell.serve()
    assert other.result.ok
    shell.feed(ev.CallbackStuck(hangs.key, "N", STUCK))
    shell.wait(2.0)
    assert "rtexit --force" in asked.result.why
    assert not shell.signals
    assert shell.state.components["A"].process == "s"
    assert shell.state.processes[key].is_alive


def test_a_slave_that_ends_as_it_was_told_to_is_listed_no_longer(shell):
    shell.state.settings.change("manager.shutdown_on_nortcs", "YES")
    shell.make("A", "s")
    asked = shell.ask(Delete("A"))
    shell.serve()
    assert not asked.replies
    assert [each.name for each in shell.state.snapshot().processes] == [shell.state.name]


def test_a_slave_that_outlives_its_kill_is_listed_again(shell):
    shell.state.settings.change("manager.shutdown_on_nortcs", "YES")
    key = shell.make("A", "s")
    shell.ask(Delete("A"), timeout_s=60.0)
    shell.serve()
    shell.wait(2 * TERM_S)
    assert (key, KILL) in shell.signals
    assert "s" in [each.name for each in shell.state.snapshot().processes]


# the end of all


def ending(shell):
    """Return the components that are asked to end just now."""
    assert {each.op for each in shell.calls} <= {"delete"}
    return [each.message["instance"] for each in shell.calls]


def ends(shell, instance):
    (call,) = (each for each in shell.calls if each.message["instance"] == instance)
    shell.calls.remove(call)
    shell.say(call.key, gone=instance)
    shell.reply(call)


def test_at_the_end_each_process_ends_its_latest_component_first(shell):
    for instance, slave in (("A", "s"), ("B", "t"), ("C", "s")):
        shell.make(instance, slave)
    shell.stop()
    assert ending(shell) == ["C", "B"]
    ends(shell, "C")
    assert ending(shell) == ["B", "A"]
    ends(shell, "A")
    assert [number for _, number in shell.signals] == [TERM]


@pytest.fixture
def joined(shell):
    """A in a slave, which is connected with B, that was made later in another one."""
    shell.make("A", "s")
    shell.make("B", "t")
    shell.ask(Connect(wire("w")))
    shell.serve()


@pytest.mark.usefixtures("joined")
def test_at_the_end_a_component_outlives_later_ones_that_it_is_connected_with(shell):
    shell.stop()
    assert ending(shell) == ["B"]
    ends(shell, "B")
    assert ending(shell) == ["A"]


@pytest.mark.usefixtures("joined")
def test_at_the_end_none_waits_for_a_process_that_fails_to_end_another(shell):
    shell.stop()
    shell.refuse(shell.next("delete"))
    assert ending(shell) == ["A"]


@pytest.mark.usefixtures("joined")
def test_an_urgent_end_waits_for_no_component(shell):
    shell.stop()
    shell.feed(ev.StopRequested(is_urgent=True))
    assert {number for _, number in shell.signals} == {KILL}
    assert ending(shell) == ["B"]  # asked before; nobody waits for its answer
