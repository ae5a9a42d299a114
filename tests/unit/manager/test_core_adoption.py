"""Slaves that outlived their manager, seen by the core of the next one."""

from __future__ import annotations

import signal

import pytest
from fake_shell import FakeShell, facts, wire

from rtkit.deployment.actions import Connect, Create, Delete, Disconnect, EndSlave
from rtkit.errors import Malformed
from rtkit.manager.core import events as ev
from rtkit.manager.core import manager_properties
from rtkit.manager.core.adoption import SETTLE_S
from rtkit.manager.core.modules import TRIAL


def test_what_a_found_slave_holds_is_known_again(shell: FakeShell) -> None:
    key = shell.find(300, "s", ["A"])
    facts = shell.state.components["A"]
    assert (facts.process, facts.names) == ("s", ("localhost/A.rtc",))
    assert shell.state.processes[key].pid == 300
    asked = shell.ask(Delete("A"))
    shell.serve()
    shell.end(key, "exit status 0")
    assert asked.result.ok


def test_a_connector_is_known_when_both_ends_are_back(shell: FakeShell) -> None:
    shell.find(300, "a", ["A"], [wire("w")])
    assert shell.state.connectors == {}
    shell.find(301, "b", ["B"], [wire("w")])
    assert set(shell.state.connectors) == {"w"}
    shell.wait(2 * SETTLE_S)
    assert set(shell.state.connectors) == {"w"}
    asked = shell.ask(Disconnect("w"))
    shell.serve()
    assert asked.result.ok


def test_a_connector_whose_other_end_stays_away_is_cut(shell: FakeShell) -> None:
    key = shell.find(300, "a", ["A"], [wire("w")])
    shell.wait(2 * SETTLE_S)
    assert (key, {"op": "unlink", "connector_id": "w"}) in shell.told
    assert shell.state.loose == {}


def test_an_end_is_no_connector_though_the_other_component_lives(shell: FakeShell) -> None:
    shell.make("B", "b")
    shell.find(300, "a", ["A"], [wire("w")])
    assert shell.state.connectors == {}
    shell.wait(2 * SETTLE_S)
    assert shell.state.connectors == {}


def test_a_connector_inside_one_slave_is_known_at_once(shell: FakeShell) -> None:
    shell.find(300, "a", ["A", "B"], [wire("w")])
    assert set(shell.state.connectors) == {"w"}


def test_a_connector_can_be_made_again_while_an_end_of_it_is_left(shell: FakeShell) -> None:
    key = shell.find(300, "a", ["A"], [wire("w")])
    shell.make("B", "b")
    asked = shell.ask(Connect(wire("w")))
    assert (key, {"op": "unlink", "connector_id": "w"}) in shell.told
    shell.serve()
    assert asked.result.ok
    shell.told.clear()
    shell.wait(2 * SETTLE_S)
    assert set(shell.state.connectors) == {"w"}
    assert shell.told == []


def test_an_instance_that_lives_elsewhere_by_now_is_dropped_by_the_slave(shell: FakeShell) -> None:
    shell.make("A")
    key = shell.find(300, "s", ["A", "B"])
    assert (key, {"op": "delete", "instance": "A"}) in shell.told
    assert shell.state.containers["A"] == ev.OWN_PROCESS
    assert shell.state.containers["B"] == key


def test_a_slave_takes_the_place_of_its_zombie(shell: FakeShell) -> None:
    old = shell.make("A", "s")
    shell.end(old)
    assert shell.state.components["A"].zombie
    key = shell.find(300, "s", ["A"])
    assert not shell.state.components["A"].zombie
    assert set(shell.state.processes) == {ev.OWN_PROCESS, key}


def test_a_name_that_is_taken_gets_the_pid_behind_it(shell: FakeShell) -> None:
    shell.make("A", "s")
    key = shell.find(300, "s", ["B"])
    assert shell.state.processes[key].name == "s_300"


def test_a_slave_whose_line_broke_keeps_its_key(shell: FakeShell) -> None:
    first = shell.find(300, "s", ["A"])
    assert shell.find(300, "s", ["A"]) == first
    assert list(shell.state.containers) == ["A"]


def test_a_found_slave_that_is_killed_leaves_a_zombie(shell: FakeShell) -> None:
    key = shell.find(300, "s", ["A"])
    shell.end(key, "exit status unknown")
    assert shell.state.components["A"].zombie == "exit status unknown"


@pytest.mark.parametrize("held", [None, {}, [1], [{"instance": 3}]])
def test_what_cannot_be_read_changes_nothing_else(held: object, shell: FakeShell) -> None:
    shell.make("A")
    with pytest.raises(Malformed):
        shell.feed(ev.SlaveFound(300, "s", held, []))
    assert list(shell.state.components) == ["A"]


def test_the_end_of_a_slave_ends_its_loose_connectors(shell: FakeShell) -> None:
    shell.end(shell.find(300, "a", ["A"], [wire("w")]))
    assert shell.state.loose == {}
    shell.find(301, "b", ["B"], [wire("w")])
    assert shell.state.connectors == {}


def test_what_ended_while_a_line_was_broken_is_forgotten(shell: FakeShell) -> None:
    shell.find(300, "s", ["A", "B"])
    shell.find(300, "s", ["B"])
    assert list(shell.state.components) == ["B"]


def test_an_instance_that_is_just_being_made_elsewhere_is_dropped_by_the_slave(
    shell: FakeShell,
) -> None:
    asked = shell.ask(Create("Thing?instance_name=A"))
    key = shell.find(300, "s", ["A"])
    assert (key, {"op": "delete", "instance": "A"}) in shell.told
    shell.serve()
    assert asked.result.ok
    assert shell.state.containers["A"] == ev.OWN_PROCESS


def test_a_slave_that_is_found_while_everything_ends_is_ended_too(shell: FakeShell) -> None:
    shell.make("A")
    shell.stop()
    key = shell.find(300, "s", ["B"])
    assert key in shell.killed()


def test_names_given_twice_are_one(shell: FakeShell) -> None:
    held = {**facts("A"), "names": ["localhost/a.rtc", "localhost/a.rtc"]}
    shell.feed(ev.SlaveFound(300, "s", [held], []))
    assert shell.state.components["A"].names == ("localhost/a.rtc",)


def test_what_cannot_be_read_makes_no_process(shell: FakeShell) -> None:
    for components in (None, [1], [facts("a/b")], [{**facts("A"), "type": 5}]):
        with pytest.raises(Malformed):
            shell.feed(ev.SlaveFound(300, "s", components, []))
    assert list(shell.state.processes) == [ev.OWN_PROCESS]


def test_a_found_slave_that_holds_nothing_is_ended(shell: FakeShell) -> None:
    key = shell.find(300, "s")
    assert shell.signals == [(key, signal.SIGTERM)]
    shell.end(key, "exit status 0")
    assert list(shell.state.processes) == [ev.OWN_PROCESS]


def unsaid(shell: FakeShell, pid: int, name: str, instances: list[str], silence: str) -> int:
    held = [{**facts(each), "names": [f"localhost/{each}.rtc"]} for each in instances]
    shell.feed(ev.SlaveFound(pid, name, held, [], silence=silence))
    return shell.adopted[pid]


@pytest.mark.parametrize(
    ("silence", "why"),
    [
        ("stopped", "slave s does not answer: it is stopped"),
        ("does not answer", "slave s does not answer"),
    ],
)
def test_a_slave_that_says_nothing_is_shown_with_what_it_holds(
    silence: str, why: str, shell: FakeShell
) -> None:
    key = unsaid(shell, 300, "s", ["A"], silence)
    assert shell.state.components["A"].trouble == silence
    assert shell.state.processes[key].state == "silent"
    assert shell.state.snapshot().processes[-1].reason == silence
    for action in (Create("Thing?manager_name=s"), Delete("A")):
        result = shell.ask(action).result
        assert result.why.startswith(why), result
    assert shell.calls == []
    assert shell.find(300, "s", ["A"]) == key
    assert shell.state.components["A"].trouble == ""
    asked = shell.ask(Delete("A"))
    shell.serve()
    shell.end(key)
    assert asked.result.ok


def test_one_that_says_nothing_is_ended_by_force_and_with_the_manager() -> None:
    for end in (EndSlave("s", is_forced=True), None):
        shell = FakeShell()
        key = unsaid(shell, 300, "s", ["A"], "stopped")
        if end is not None:
            shell.ask(end)
        else:
            shell.stop()
        assert shell.signals == [(key, signal.SIGTERM), (key, signal.SIGCONT)]
        shell.wait(60.0)
        assert shell.signals[2:] == [(key, signal.SIGKILL)]


@pytest.mark.parametrize("silence", ["", "does not answer"])
def test_one_that_was_there_to_try_a_module_is_ended(silence: str, shell: FakeShell) -> None:
    shell.feed(ev.SlaveFound(300, TRIAL, [], [], silence=silence))
    assert shell.signals == [(shell.adopted[300], signal.SIGKILL)]
    assert len(shell.state.snapshot().processes) == 1


def test_whether_a_silent_one_is_stopped_may_change(shell: FakeShell) -> None:
    key = unsaid(shell, 300, "s", ["A"], "stopped")
    shell.feed(ev.SlaveStopped(key, False))
    assert shell.state.components["A"].trouble == "does not answer"
    shell.feed(ev.SlaveStopped(key, True))
    assert shell.state.components["A"].trouble == "stopped"
    shell.end(key)
    assert shell.state.components["A"].zombie == "signal 9"


def test_a_connector_to_one_that_says_nothing_is_kept(shell: FakeShell) -> None:
    other = shell.find(301, "b", ["B"], [wire("w")])
    key = unsaid(shell, 300, "a", ["A"], "stopped")
    assert set(shell.state.connectors) == {"w"}
    shell.wait(3 * SETTLE_S)
    assert (other, {"op": "unlink", "connector_id": "w"}) not in shell.told
    assert shell.find(300, "a", ["A"], [wire("w")]) == key
    shell.wait(3 * SETTLE_S)
    assert set(shell.state.connectors) == {"w"}
    assert {message["op"] for _, message in shell.told} == {"configure"}


def test_a_slave_that_is_found_is_told_of_properties_that_may_not_be_recorded(
    shell: FakeShell,
) -> None:
    """The manager may have been killed in the commit of one that it had told already."""
    key = shell.find(300, "s", ["A"])
    assert [(each, message["op"]) for each, message in shell.told] == [(key, "configure")]


def test_a_connector_of_which_it_knows_nothing_when_it_answers_is_cut(shell: FakeShell) -> None:
    other = shell.find(301, "b", ["B"], [wire("w")])
    unsaid(shell, 300, "a", ["A"], "does not answer")
    shell.find(300, "a", ["A"], [])
    assert shell.state.connectors == {}
    assert (other, {"op": "unlink", "connector_id": "w"}) in shell.told


def test_what_ended_while_no_manager_ran_is_shown_unless_it_lives_again(shell: FakeShell) -> None:
    shell.make("B", "s")
    held = [{**facts(each), "names": [f"localhost/{each}.rtc"]} for each in "AB"]
    shell.feed(ev.SlaveExitedUnseen(300, "s", held, "signal 11"))
    assert shell.state.components["A"].zombie == "signal 11"
    assert shell.state.components["A"].names == ("localhost/A.rtc",)
    assert not shell.state.components["B"].zombie
    count = len(shell.state.processes)
    shell.feed(ev.SlaveExitedUnseen(301, "t", held[1:], "signal 11"))
    assert len(shell.state.processes) == count
    assert shell.ask(Delete("A")).result.ok
    assert len(shell.state.processes) == count - 1


@pytest.mark.parametrize(
    ("change", "is_sent"),
    [
        ({}, False),
        ({"call": 7}, False),
        ({"log_level": "DEBUG"}, True),
        ({"load_path": ["/elsewhere"]}, True),
    ],
)
def test_a_found_slave_is_sent_properties_only_if_it_has_others(
    change: dict[str, object], is_sent: bool, shell: FakeShell
) -> None:
    has = {**manager_properties.message(shell.state), **change}
    shell.feed(ev.SlaveFound(300, "s", [facts("A")], [], configured=has))
    key = shell.adopted[300]
    ops = [message.get("op") for to, message in shell.told if to == key]
    assert ("configure" in ops) is is_sent


def test_a_found_slave_that_was_sent_none_has_the_defaults(shell: FakeShell) -> None:
    paths = manager_properties.load_paths(shell.state)
    cases = [({"load_path": paths}, False), ({"load_path": ["/b"]}, True), (None, True), (3, True)]
    for pid, (has, is_sent) in enumerate(cases, 300):
        shell.feed(ev.SlaveFound(pid, f"s{pid}", [facts(f"A{pid}")], [], configured=has))
        ops = [message.get("op") for to, message in shell.told if to == shell.adopted[pid]]
        assert ("configure" in ops) is is_sent, has
    shell.state.settings.change("logger.log_level", "DEBUG")
    shell.feed(ev.SlaveFound(400, "s", [facts("B")], [], configured={"load_path": paths}))
    ops = [message.get("op") for to, message in shell.told if to == shell.adopted[400]]
    assert "configure" in ops
