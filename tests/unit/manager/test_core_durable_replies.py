"""The core and the store: answers wait for it, what it cannot take is taken back."""

from __future__ import annotations

from fake_shell import OWN, FakeShell, facts, wire

from rtkit.deployment import actions as act
from rtkit.deployment.batch import results_from_text
from rtkit.manager.core import events as ev
from rtkit.manager.core.durable_replies import RETRY_S
from rtkit.property.exchange import Reply
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import Transition

FULL = "database or disk is full (x)"


def restored(shell: FakeShell) -> list[tuple[str, str]]:
    """Have a core make again what is missing; return what it says failed."""
    replies: list[Reply] = []
    shell.feed(ev.RecoveryRequested(shell.requests.add(replies.append)))
    while shell.spawned:
        shell.fork(next(iter(shell.spawned)))
    shell.serve()
    (reply,) = replies
    return [(each.value, each.why) for each in results_from_text(reply.value())]


def heir(shell: FakeShell, boot: str = "") -> FakeShell:
    """Return a core that begins with what another one kept."""
    other = FakeShell()
    rows = [(kind, name, text) for (kind, name), text in shell.rows.items()]
    other.feed(ev.StoreRead(rows, boot))
    return other


def system() -> FakeShell:
    """A core with two components in a slave, connected, configured and active."""
    shell = FakeShell()
    shell.make("A", "s")
    shell.make("B", "s")
    asked = shell.ask(
        act.Connect(wire("w")),
        act.SetParameters("B", "default", {"p": "1"}),
        act.ChangeState("B", "0", Transition.ACTIVATE),
    )
    shell.serve()
    assert all(result.ok for result in asked.results)
    return shell


def test_an_answer_waits_until_it_is_on_the_disk(shell: FakeShell) -> None:
    asked = shell.ask(act.Create("Thing?instance_name=A"))
    call = shell.next("create")
    shell.say(OWN, facts=facts("A"))
    instructions = shell.core.handle(
        ev.ContainerReported(OWN, {"reply": call.number, "value": ""}), shell.now
    )
    (keep,) = [each for each in instructions if isinstance(each, ev.StoreRows)]
    assert [row[:2] for row in keep.rows] == [("component", "A")]
    assert not any(isinstance(each, ev.AnswerClient) for each in instructions)
    assert not asked.is_answered
    shell.feed(ev.RowsStored(keep.number))
    assert asked.result.ok


def test_a_batch_is_one_commit(shell: FakeShell) -> None:
    shell.ask(*(act.Create(f"Thing?instance_name=A{n}") for n in range(100)), ordered=False)
    commits = []
    shell._keep = lambda keep: commits.append(keep)  # type: ignore[method-assign]
    shell.serve()
    assert [len(keep.rows) for keep in commits] == [100]


def test_what_only_looks_keeps_nothing() -> None:
    shell = system()
    before = dict(shell.rows)
    shell.disk = FULL
    shell.ask(act.Tick("A", "0"))
    shell.serve()
    asked = shell.ask(act.Create("Thing?instance_name=A"))  # it is there already
    assert (asked.result.ok, shell.rows, shell.state.unkept) == (True, before, "")


def test_what_cannot_be_kept_is_taken_back_and_told() -> None:
    shell = system()
    before = dict(shell.rows)
    shell.disk = FULL
    asked = shell.ask(
        act.Create("Thing?instance_name=C&manager_name=s"),
        act.Connect(wire("v", "C.out", "B.in")),
        act.SetParameters("A", "default", {"p": "2"}),
    )
    shell.serve()
    assert [(each.ok, each.why) for each in asked.results] == [
        (False, f"what is wished cannot be recorded: {FULL}"),
        (False, f"what is wished cannot be recorded: {FULL}"),
        (False, f"done all the same, but what is wished cannot be recorded: {FULL}"),
    ]
    assert (list(shell.state.components), list(shell.state.connectors)) == (["A", "B"], ["w"])
    assert shell.rows == before
    (own, _) = shell.state.snapshot().processes
    assert own.reason == f"the desired state cannot be recorded: {FULL}"


def test_a_store_that_is_gone_is_written_anew_from_what_is_known() -> None:
    """Who asked for something meanwhile hears of it only when all is on the disk again."""
    shell = system()
    before = dict(shell.rows)
    shell.is_disk_lost = True
    asked = shell.ask(act.SetParameters("A", "default", {"p": "2"}))
    shell.serve()
    assert asked.result.ok
    assert shell.rows.keys() == before.keys()
    assert '"p":"2"' in shell.rows["component", "A"]
    (own, _) = shell.state.snapshot().processes
    assert own.reason == "the store is gone; all is written anew"


def test_a_store_that_is_gone_and_cannot_be_made_is_like_a_full_disk() -> None:
    shell = system()
    shell.is_disk_lost, shell.disk = True, FULL
    asked = shell.ask(act.Create("Thing?instance_name=C&manager_name=s"))
    shell.serve()
    assert asked.result.why == f"what is wished cannot be recorded: {FULL}"
    assert sorted(shell.state.components) == ["A", "B"]
    shell.disk = ""
    shell.ask(act.SetParameters("A", "default", {"p": "2"}))
    shell.serve()
    assert {name for kind, name in shell.rows if kind == "component"} == {"A", "B"}
    assert ("wire", "w") in shell.rows


def test_while_the_disk_is_full_nothing_new_begins_but_what_rests_is_rested() -> None:
    shell = system()
    shell.disk = FULL
    shell.ask(act.Create("Thing?instance_name=C"))
    shell.serve()
    refused = shell.ask(act.Create("Thing?instance_name=D"))
    assert not shell.calls
    assert refused.replies[0].error == "refused"
    rested = shell.ask(act.ChangeState("B", "0", Transition.DEACTIVATE))
    shell.serve()
    assert rested.result.why == f"done all the same, but what is wished cannot be recorded: {FULL}"
    shell.disk = ""
    again = shell.ask(act.Create("Thing?instance_name=D"))
    shell.serve()
    assert again.result.ok
    assert not shell.state.unkept
    assert '"active"' not in shell.rows["component", "B"]
    assert ("component", "C") not in shell.rows


def test_what_could_not_be_kept_is_tried_again_each_second_until_it_can() -> None:
    shell = system()
    shell.disk = FULL
    asked = shell.ask(act.SetParameters("A", "default", {"p": "2"}))
    shell.serve()
    assert asked.result.why == f"done all the same, but what is wished cannot be recorded: {FULL}"
    shell.wait(10 * RETRY_S)
    assert shell.state.unkept == FULL
    shell.disk = ""
    shell.wait(RETRY_S)
    assert '"p":"2"' in shell.rows["component", "A"]
    assert not shell.state.unkept
    commits = []
    shell._keep = lambda keep: commits.append(keep)  # type: ignore[method-assign]
    shell.wait(10 * RETRY_S)
    assert commits == []


def test_the_end_of_the_machine_keeps_what_is_not_kept_yet() -> None:
    shell = system()
    shell.disk = FULL
    shell.ask(act.SetParameters("A", "default", {"p": "2"}))
    shell.serve()
    shell.disk = ""
    shell.feed(ev.StopRequested(is_kept=True))
    assert '"p":"2"' in shell.rows["component", "A"]


def test_all_is_made_again_when_nothing_has_survived() -> None:
    shell = heir(system())
    assert restored(shell) == []
    assert list(shell.state.components) == ["A", "B"]
    assert {each.process for each in shell.state.components.values()} == {"s"}
    assert list(shell.state.connectors) == ["w"]


def test_what_is_made_again_is_configured_connected_and_active_in_this_order() -> None:
    shell = heir(system())
    shell.feed(ev.RecoveryRequested(shell.requests.add(lambda _reply: None)))
    shell.fork("s")
    ops = []
    while shell.calls:
        call = shell.calls.pop(0)
        ops.append(call.op)
        if call.op == "create":
            made = parse_create(call.message["create"]).instance_name
            shell.say(call.key, facts=facts(made))
        shell.reply(call)
    assert ops == ["create", "create", "set", "link", "change_state"]


def test_what_lives_is_let_be_and_only_the_rest_is_made() -> None:
    before = system()
    before.make("C", "t")
    shell = heir(before)
    shell.find(900, "s", ["A", "B"], [wire("w")])
    assert restored(shell) == []
    assert list(shell.state.components) == ["A", "B", "C"]
    assert not [each for each in shell.told if each[1]["op"] == "unlink"]


def test_what_lives_and_is_not_known_is_wished_from_then_on(shell: FakeShell) -> None:
    create = "Thing?instance_name=A&manager_name=s"
    shell.feed(ev.SlaveFound(900, "s", [{**facts("A"), "create": create}], []))
    assert restored(shell) == []
    assert create in shell.rows["component", "A"]


def test_what_was_ended_on_purpose_does_not_come_back() -> None:
    shell = system()
    shell.ask(act.Delete("A"))
    shell.serve()
    assert sorted(shell.rows) == [("component", "B")]
    shell.stop()
    assert shell.rows == {}


def test_the_end_of_the_machine_is_none_of_the_wishes() -> None:
    shell = system()
    before = dict(shell.rows)
    shell.feed(ev.StopRequested(is_kept=True))
    shell.serve()
    shell.wait(10.0)
    assert shell.rows == before


def test_who_died_by_himself_stays_dead_until_the_machine_starts_anew() -> None:
    shell = system()
    shell.feed(ev.StoreRead((), "one"))
    shell.end(shell.state.containers["A"])
    shell.wait(2.0)
    same = heir(shell, "one")
    assert restored(same) == []
    assert [each.zombie for each in same.state.components.values()] == ["signal 9", "signal 9"]
    other = heir(shell, "two")
    assert restored(other) == []
    assert [each.zombie for each in other.state.components.values()] == ["", ""]


def test_who_dies_with_his_manager_did_not_die_by_himself() -> None:
    shell = system()
    shell.end(shell.state.containers["A"])
    shell.wait(0.5)
    other = heir(shell)
    assert restored(other) == []
    assert [each.zombie for each in other.state.components.values()] == ["", ""]


def test_failures_of_restoring_are_told_and_the_rest_is_done() -> None:
    shell = heir(system())
    replies: list[Reply] = []
    shell.feed(ev.RecoveryRequested(shell.requests.add(replies.append)))
    shell.fork("s")
    shell.refuse(shell.next("create"))
    shell.serve()
    results = results_from_text(replies[0].value())
    assert [(each.value, each.why) for each in results] == [("create A", "no such thing")]
    assert list(shell.state.components) == ["B"]
    assert list(shell.state.kept.components) == ["A", "B"]  # it is tried again at the next start
