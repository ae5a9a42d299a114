"""Guests: processes that come by themselves, seen by the core."""

from __future__ import annotations

from fake_shell import FakeShell, facts, wire

from rtkit.deployment.actions import Connect, Create, Delete
from rtkit.deployment.capture import SystemHeading, capture
from rtkit.manager.core import events as ev


def test_what_a_guest_holds_is_shown_under_the_usual_name(shell: FakeShell) -> None:
    key = shell.visit(300, "rtprint_300", ["A"])
    assert shell.state.components["A"].names == ("localhost/A.rtc",)
    assert (key, {"welcome": ["A"]}) in shell.told
    process = shell.state.snapshot().processes[-1]
    assert (process.name, process.is_guest, process.is_slave) == ("rtprint_300", True, False)


def test_a_name_that_is_taken_is_not_given_to_a_guest(shell: FakeShell) -> None:
    shell.make("A")
    key = shell.visit(300, "rtprint_300", ["A", "B"])
    assert (key, {"op": "delete", "instance": "A"}) in shell.told
    assert (key, {"welcome": ["B"]}) in shell.told
    assert shell.state.containers["A"] == ev.OWN_PROCESS


def test_a_guest_leaves_no_zombie_and_no_connector(shell: FakeShell) -> None:
    other = shell.make("B", "s")
    key = shell.visit(300, "rtprint_300", ["A"])
    asked = shell.ask(Connect(wire("w")))
    shell.serve()
    assert asked.result.ok
    shell.end(key)
    assert set(shell.state.components) == {"B"}
    assert shell.state.connectors == {}
    assert key not in shell.state.processes
    assert (other, {"op": "unlink", "connector_id": "w"}) in shell.told


def test_what_a_guest_holds_can_be_ended_from_outside_and_the_guest_is_not(
    shell: FakeShell,
) -> None:
    shell.visit(300, "rtprint_300", ["A"])
    asked = shell.ask(Delete("A"))
    shell.serve()
    assert asked.result.ok
    shell.wait(60)
    assert shell.signals == []


def test_a_stop_ends_components_of_guests_and_sends_guests_no_signal(shell: FakeShell) -> None:
    key = shell.visit(300, "rtprint_300", ["A"])
    shell.feed(ev.StopRequested())
    call = shell.next("delete")
    assert (call.key, call.message["instance"]) == (key, "A")
    shell.reply(call)
    assert shell.signals == []
    assert shell.is_finished


def test_nothing_is_created_in_a_guest(shell: FakeShell) -> None:
    shell.visit(300, "visitor", ["A"])
    shell.ask(Create("Type?instance_name=B&manager_name=visitor"))
    assert "visitor" in shell.spawned


def test_a_guest_is_no_part_of_a_captured_system(shell: FakeShell) -> None:
    shell.make("B")
    shell.visit(300, "rtprint_300", ["A"])
    heading = SystemHeading("2026-01-01T00:00:00")
    profile = capture(shell.state.snapshot(), heading, takes_all=True)
    assert [component.instance_name for component in profile.components] == ["B"]


def test_one_run_by_hand_is_saved_as_what_a_slave_of_its_own_makes(shell: FakeShell) -> None:
    made = {"create": "Type?instance_name=A&manager_name=manager_%25p", "module": "/m/Type.py"}
    shell.feed(ev.SlaveFound(300, "Type_300", [{**facts("A"), **made}], [], is_guest=True))
    key = shell.adopted[300]
    shell.feed(ev.ContainerReported(key, {"facts": facts("A")}))  # these do not tell it again
    heading = SystemHeading("2026-01-01T00:00:00")
    (component,) = capture(shell.state.snapshot(), heading, takes_all=True).components
    told = {each.name: each.value for each in component.properties}
    assert told == {"rtkit.create": made["create"], "rtkit.module": made["module"]}


def test_a_debugger_in_it_is_told_and_breaks_no_rule(shell: FakeShell) -> None:
    made = {"create": "Type?instance_name=A&rtkit.health.stuck=0.2:restart"}
    shell.feed(ev.SlaveFound(300, "Type_300", [{**facts("A"), **made}], [], is_guest=True))
    text = "in a debugger since 12:00:00 (a.py:7 in on_execute)"
    shell.feed(ev.CallbackStuck(shell.adopted[300], "A", text, True))
    shell.wait(5.0)
    assert shell.state.components["A"].trouble == text
    assert (shell.signals, shell.calls) == ([], [])
