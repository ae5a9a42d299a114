"""The core answers each batch once, bounds each wait, and comes to an orderly end."""

from __future__ import annotations

import signal

import pytest
from endings import heir
from fake_shell import OWN, FakeShell

from rtkit.deployment.actions import ActivateSet, ChangeState, Create, Delete, SetParameters, Tick
from rtkit.deployment.batch import stamped_id
from rtkit.errors import Refused
from rtkit.manager.core import events as ev
from rtkit.manager.core import procedures
from rtkit.manager.core.batches import REMEMBERED, TOO_OLD
from rtkit.manager.core.deletion import FINALISE_S, TERM_S
from rtkit.property.exchange import NOT_BEGUN, Reply
from rtkit.rtc.enums import ReturnCode, Transition


def activate(instance):
    return ChangeState(instance, "0", Transition.ACTIVATE)


def test_an_empty_batch_is_answered(shell):
    assert shell.ask().results == ()


def test_in_order_the_next_begins_when_the_one_before_is_done(shell):
    asked = shell.ask(Create("Thing?instance_name=A"), Create("Thing?instance_name=B"))
    assert len(shell.calls) == 1
    shell.serve()
    assert [result.value for result in asked.results] == ["A", "B"]


def test_a_batch_that_comes_again_is_answered_and_not_done_again(shell):
    """While it is under way, afterwards, and by the next manager."""
    first = shell.ask(Create("Thing"), id="x")
    again = shell.ask(Create("Thing"), id="x")
    shell.serve()
    assert first.replies == again.replies
    assert first.result.value == "Thing0"
    late = shell.ask(Create("Thing"), id="x")
    assert late.replies == first.replies
    other = heir(shell)
    assert other.ask(Create("Thing"), id="x").replies == first.replies
    new = other.ask(Create("Thing"), id="y")
    other.serve()
    assert new.result.value == "Thing0"  # which nobody has restored here
    assert not [call for call in shell.calls if call.op == "create"]


def test_what_was_refused_for_the_disk_may_be_asked_again(shell):
    shell.make("A")
    shell.disk = "full"
    asked = shell.ask(Create("Thing"), id="x")
    shell.serve()
    refused = shell.ask(Create("Thing"), id="y")
    assert (asked.result.ok, refused.replies[0].error) == (False, "refused")
    shell.disk = ""
    shell.wait(2.0)
    assert not [name for kind, name in shell.rows if kind == "answered"]
    again = shell.ask(Create("Thing"), id="y")
    shell.serve()
    assert again.result.value == "Thing0"


def test_a_batch_that_may_have_been_forgotten_is_refused_by_name(shell):
    """Also by the next manager; what is younger, or of another run of the machine, is not."""
    ids = [stamped_id("0123456789", moment, "ab") for moment in range(REMEMBERED + 3)]
    shell.make("A")
    for number, id in enumerate(ids):
        shell.ask(SetParameters("A", "default", {"p": str(number)}), id=id)
        shell.serve()
    for manager in (shell, heir(shell)):
        again = manager.ask(Create("Thing"), id=ids[1])
        manager.serve()
        assert again.replies == [Reply(TOO_OLD.format(ids[1]), Refused.kind)]
        assert manager.ask(Create("Thing"), id=ids[-1]).result.ok
    young = stamped_id("0123456789", REMEMBERED + 9, "ab")
    for id in (young, stamped_id("fedcba9876", 1, "ab"), "no-stamp"):
        new = shell.ask(Create("Thing"), id=id)
        shell.serve()
        assert new.result.ok


def test_only_the_last_answers_are_remembered(shell):
    shell.make("A")
    for number in range(REMEMBERED + 3):
        shell.ask(SetParameters("A", "default", {"p": str(number)}), id=str(number))
        shell.serve()
        assert len(shell.rows) <= REMEMBERED + 1
    rows = [int(name) for kind, name in shell.rows if kind == "answered"]
    assert rows == list(range(3, REMEMBERED + 3))
    shell.ask(Tick("A", "0"), id="look")  # changes nothing that is kept
    shell.serve()
    assert ("answered", "look") not in shell.rows


def test_in_order_the_first_failure_ends_it(shell):
    asked = shell.ask(Delete("No"), Create("Thing?instance_name=A"))
    assert [result.kind for result in asked.results] == ["not-found"]
    assert not shell.calls


def test_without_order_all_are_tried_and_results_keep_their_places(shell):
    shell.make("A")
    asked = shell.ask(activate("A"), Delete("No"), activate("A"), ordered=False)
    first, second = shell.next("change_state"), shell.next("change_state")
    shell.reply(second)
    shell.refuse(first, Refused("precondition not met"), "PRECONDITION_NOT_MET")
    codes = [result.code for result in asked.results]
    assert codes == [ReturnCode.PRECONDITION_NOT_MET, ReturnCode.BAD_PARAMETER, ReturnCode.OK]


@pytest.mark.parametrize("ordered", [True, False])
def test_a_batch_may_be_long(shell, ordered):
    shell.make("A")
    actions = [Create("Thing?instance_name=A")] * 5000
    assert len(shell.ask(*actions, ordered=ordered).results) == 5000


def test_what_is_asked_of_a_component_goes_to_its_process(shell):
    key = shell.make("A", "s")
    actions = (SetParameters("A", "default", {"x": "1"}), ActivateSet("A", "b"), activate("A"))
    shell.ask(*actions, ordered=False)
    assert [call.key for call in shell.calls] == [key] * 3
    messages = [dict(call.message) for call in shell.calls]
    assert [(each.pop("call") > 0, each.pop("until")) for each in messages] == [(True, 1010.0)] * 3
    assert messages == [
        {"op": "set", "set_id": "default", "values": {"x": "1"}, "instance": "A"},
        {"op": "activate_set", "set_id": "b", "values": {}, "instance": "A"},
        {
            "op": "change_state",
            "context": "0",
            "transition": "activate",
            "wait": True,
            "instance": "A",
        },
    ]


def test_a_batch_that_comes_too_late_is_not_begun(shell):
    shell.make("A")
    asked = shell.ask(activate("A"), until=shell.now - 0.1)
    assert not shell.calls
    assert (asked.result.kind, asked.result.why) == ("unreachable", NOT_BEGUN)


def test_of_a_batch_whose_client_gave_up_the_rest_is_not_begun(shell):
    shell.make("A")
    shell.make("B")
    asked = shell.ask(activate("A"), activate("B"), until=shell.now + 1)
    shell.now += 2
    shell.reply(shell.next("change_state"))
    assert [result.why for result in asked.results] == ["", NOT_BEGUN]
    assert not shell.calls


def test_holders_are_told_until_when_to_begin_but_not_of_what_has_to_go(shell):
    shell.make("A", "s")
    shell.ask(Delete("A"))
    assert "until" not in shell.next("delete").message


def test_each_wait_is_bounded_and_a_late_answer_ignored(shell):
    shell.make("A")
    asked = shell.ask(activate("A"), activate("A"), timeout_s=2.0)
    call = shell.next("change_state")
    shell.wait(1.9)
    assert not asked.is_answered
    shell.wait(0.2)
    assert asked.result.kind == "unreachable"
    shell.reply(call)
    shell.reply(call)
    assert len(asked.replies) == 1


def test_an_answer_that_comes_with_the_last_moment_counts(shell):
    shell.make("A")
    asked = shell.ask(activate("A"), timeout_s=2.0)
    shell.now += 5.0  # the loop was held up: both are there at once
    shell.reply(shell.next("change_state"))
    assert asked.result.ok


def test_short_and_long_waits_end_each_at_its_time(shell):
    shell.make("A")
    waits = (7.0, 1.0, 4.0)
    asked = [shell.ask(activate("A"), timeout_s=wait) for wait in waits]
    for moment in (1.0, 4.0, 7.0):
        shell.wait(moment - (shell.now - 1000.0))
        for each, wait in zip(asked, waits, strict=True):
            assert each.is_answered is (wait <= moment)


def test_long_waits_that_are_over_do_not_pile_up(shell):
    shell.make("A")
    pending = shell.ask(activate("A"), timeout_s=1000.0)
    first = shell.next("change_state")
    for _ in range(1000):
        shell.ask(activate("A"), timeout_s=100_000.0)
        shell.reply(shell.next("change_state"))
    assert len(shell.core._tasks._deadlines) < 200
    shell.reply(first)
    assert pending.result.ok
    assert shell.core.is_idle
    assert shell.wake_at is None


def test_a_fault_of_a_procedure_is_told_and_ends_nothing_else(shell, monkeypatch, caplog):
    def broken(state, action):
        raise ZeroDivisionError("oops")
        yield

    monkeypatch.setitem(procedures._PROCEDURES, Delete, broken)
    asked = shell.ask(Delete("A"), Create("Thing"), ordered=False)
    shell.serve()
    assert [result.why for result in asked.results] == ["ZeroDivisionError: oops", ""]
    assert "a procedure failed" in caplog.text


# stopped slaves


def test_a_stopped_slave_is_shown_and_answered_for_at_once(shell):
    key = shell.make("A", "s")
    shell.feed(ev.SlaveStopped(key, True))
    assert shell.state.components["A"].trouble == "stopped"
    assert shell.ask(activate("A")).result.why == "slave s does not answer: it is stopped"
    assert not shell.calls
    shell.feed(ev.SlaveStopped(key, False))
    assert shell.state.components["A"].trouble == ""
    asked = shell.ask(activate("A"))
    shell.serve()
    assert asked.result.ok


def test_what_was_asked_before_it_stopped_is_answered_when_it_goes_on(shell):
    key = shell.make("A", "s")
    asked = shell.ask(activate("A"))
    shell.feed(ev.SlaveStopped(key, True))
    shell.feed(ev.SlaveStopped(key, False))
    shell.serve()
    assert asked.result.ok


# the end


def test_the_end_of_nothing_is_at_once(shell):
    shell.stop()
    assert shell.is_finished


def test_components_end_in_reverse_order_then_the_slaves(shell):
    a = shell.make("A", "a")
    shell.make("B")
    shell.make("C", "a")
    shell.stop()
    for instance in "CBA":
        call = shell.next("delete")
        assert call.message["instance"] == instance
        assert shell.signals == []
        shell.reply(call)
    assert shell.signals == [(a, signal.SIGTERM)]
    assert not shell.is_finished
    shell.end(a, "exit status 0")
    assert shell.is_finished
    assert not shell.state.components


def test_a_slave_that_ignores_term_is_killed(shell):
    a, b = shell.make("A", "a"), shell.make("B", "b")
    shell.stop()
    shell.serve()
    shell.end(b)
    shell.wait(TERM_S)
    assert shell.killed() == [a]
    shell.end(a)
    assert shell.is_finished


def test_the_end_does_not_wait_for_what_the_kernel_does_not_kill(shell):
    shell.make("A", "a")
    shell.stop()
    shell.serve()
    shell.wait(2 * TERM_S)
    assert shell.is_finished


def test_other_ends_do_not_prolong_the_grace_of_a_slave(shell):
    keys = [shell.make(f"A{n}", f"s{n}") for n in range(5)]
    shell.stop()
    shell.serve()
    for key in keys[1:]:
        shell.wait(0.4)
        shell.end(key)
    shell.wait(0.5)
    assert shell.killed() == [keys[0]]


def test_hung_components_have_one_grace_together(shell):
    for number in range(10):
        shell.make(f"A{number}", f"s{number}")
    shell.stop()
    shell.wait(FINALISE_S)
    assert len([n for _, n in shell.signals if n == signal.SIGTERM]) == 10
    shell.wait(TERM_S)
    assert len(shell.killed()) == 10
    for key in shell.killed():
        shell.end(key)
    assert shell.is_finished


def test_a_stopped_slave_is_not_asked_but_woken_to_end(shell):
    a = shell.make("A", "a")
    shell.make("B")
    shell.feed(ev.SlaveStopped(a, True))
    shell.stop()
    call = shell.next("delete")
    assert call.message["instance"] == "B"
    shell.reply(call)
    assert shell.signals == [(a, signal.SIGTERM), (a, signal.SIGCONT)]


def test_a_slave_that_is_stopped_while_it_is_asked_to_end_takes_no_grace(shell):
    a = shell.make("A", "a")
    shell.make("B")
    shell.stop()
    assert shell.next("delete").message["instance"] == "B"
    shell.wait(0.1)
    shell.feed(ev.SlaveStopped(a, True))
    assert not shell.signals
    shell.wait(FINALISE_S)
    assert shell.signals[:2] == [(a, signal.SIGTERM), (a, signal.SIGCONT)]


def test_a_slave_that_is_stopped_while_it_ends_a_component_takes_no_grace(shell):
    a = shell.make("A", "a")
    shell.stop()
    shell.next("delete")
    shell.feed(ev.SlaveStopped(a, True))
    assert shell.signals == [(a, signal.SIGTERM), (a, signal.SIGCONT)]


def test_in_haste_slaves_are_killed_and_nobody_is_waited_for(shell):
    a = shell.make("A", "a")
    shell.make("B")
    shell.make("C")
    shell.stop()
    assert not shell.is_finished
    shell.feed(ev.StopRequested(is_urgent=True))
    assert shell.signals == [(a, signal.SIGKILL)]
    shell.end(a)
    assert shell.is_finished


def test_haste_also_spares_the_grace_of_those_that_were_told_to_end(shell):
    a = shell.make("A", "a")
    shell.stop()
    shell.reply(shell.next("delete"))
    assert shell.signals == [(a, signal.SIGTERM)]
    shell.feed(ev.StopRequested(is_urgent=True))
    assert shell.killed() == [a]
    shell.end(a)
    assert shell.is_finished


def test_stopping_answers_what_is_under_way_and_refuses_what_comes(shell):
    shell.make("A")
    working = shell.ask(activate("A"), Create("Thing?instance_name=B"))
    parallel = shell.ask(activate("A"), activate("A"), ordered=False)
    starting = shell.ask(Create("Thing?manager_name=s"))
    shell.stop()
    for asked in (working, parallel, starting):
        assert {result.why for result in asked.results} == {"the manager is stopping"}
    (reply,) = shell.ask(activate("A")).replies
    assert (reply.error, reply.text) == ("refused", "the manager is stopping")
    assert "B" not in shell.state.claims
    shell.serve()
    key = shell.fork("s")
    assert shell.killed()[-1] == key
    shell.end(key)
    assert shell.is_finished
    assert shell.core.is_idle


def test_asking_twice_for_the_end_is_asking_once(shell):
    shell.make("A")
    shell.stop()
    shell.stop()
    assert len(shell.calls) == 1
    shell.serve()
    assert shell.is_finished


def test_a_slave_that_dies_during_the_end(shell):
    a = shell.make("A", "a")
    shell.make("B", "a")
    shell.stop()
    shell.end(a)
    assert shell.is_finished


def test_nothing_is_instructed_twice(shell):
    shell.make("A")
    shell.ask(activate("A"))
    assert shell.feed(ev.TimerExpired()) == [ev.WakeAt(1010.0)]
    assert shell.state.processes[OWN].is_alive


def test_slaves_of_an_ordered_batch_start_side_by_side(shell: FakeShell) -> None:
    asked = shell.ask(*(Create(f"Thing?instance_name={n}&manager_name={n}s") for n in "ABC"))
    assert list(shell.spawned) == ["As", "Bs", "Cs"]
    for name in ("Cs", "As", "Bs"):
        shell.fork(name)
    shell.serve()
    assert [result.value for result in asked.results] == ["A", "B", "C"]
    assert shell.signals == []


@pytest.mark.parametrize("is_late", [False, True])
def test_slaves_that_a_failed_batch_does_not_need_are_ended(
    is_late: bool, shell: FakeShell
) -> None:
    asked = shell.ask(*(Create(f"Thing?instance_name={n}&manager_name={n}s") for n in "AB"))
    first = shell.fork("As")
    second = shell.spawned["Bs"] if is_late else shell.fork("Bs")
    shell.refuse(shell.next("create"))
    assert not asked.result.ok
    if is_late:
        shell.fork("Bs")
    assert {key for key, _ in shell.signals} == {first, second}
