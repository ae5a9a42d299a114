"""Interpreter of state machines: time, steps, do actions, edits, what goes round without end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rtkit.services.statemachine.interpreter import Interpreter, MachineEvent
from rtkit.services.statemachine.model import Machine
from rtkit.services.statemachine.rdf import read_machine

HEAD = "@prefix sm: <urn:rtkit:statemachine#> . @prefix : <#> . "


def machine(text: str) -> Machine:
    return read_machine(f"{HEAD}:m a sm:Machine ; {text}")


DOOR = """sm:initial :shut ; sm:variable [ sm:name "n" ; sm:value 0 ] .
:shut a sm:State ; sm:transition [ sm:on "open" ; sm:to :open ] .
:open a sm:State ;
    sm:entry [ sm:set "light.on" ; sm:value "true" ] ;
    sm:do [ sm:set "fan.speed" ; sm:expression "variables.n + 1" ; sm:every 0.5 ] ;
    sm:exit [ sm:set "light.on" ; sm:value "false" ] ;
    sm:transition ( [ sm:when "wind.speed > 5" ; sm:to :shut ]
                    [ sm:after 10 ; sm:when "variables.n < 3" ; sm:to :shut ] ) ."""


@pytest.fixture
def door() -> Interpreter:
    made = Interpreter(machine(DOOR))
    made.command("start", 0.0)
    return made


def sent(sends: Any) -> list[tuple[str, str]]:
    return [(each.target, each.value) for each in sends]


def test_entry_do_and_exit_are_sent_in_order(door: Interpreter) -> None:
    assert sent(door.take(MachineEvent("open"), 1.0)) == [("light.on", "true"), ("fan.speed", "1")]
    assert sent(door.take(MachineEvent("wind.speed", 6, True), 1.1)) == [("light.on", "false")]
    assert door.state == "shut"


def test_do_actions_are_repeated_until_the_state_is_left(door: Interpreter) -> None:
    door.take(MachineEvent("open"), 1.0)
    assert door.next_time() == 1.5
    assert door.tick(1.4) == []
    assert sent(door.tick(1.5)) == [("fan.speed", "1")]
    assert sent(door.tick(9.0)) == [("fan.speed", "1")], "no burst for what was slept through"
    door.tick(11.0)
    assert (door.state, door.next_time()) == ("shut", None)


def test_a_time_out_with_a_condition_waits_for_both(door: Interpreter) -> None:
    door.assign("n", 5, 0.5)
    door.take(MachineEvent("open"), 1.0)
    door.tick(20.0)
    assert door.state == "open"
    door.assign("n", 1, 21.0)
    assert door.state == "shut"


def test_time_stands_still_while_it_is_paused(door: Interpreter) -> None:
    door.take(MachineEvent("open"), 1.0)
    door.command("pause", 3.0)
    assert door.next_time() is None
    assert door.tick(50.0) == []
    door.command("start", 100.0)
    door.tick(107.9)
    assert door.state == "open"
    door.tick(108.0)
    assert door.state == "shut"


def test_a_step_takes_one_transition_and_events_wait(door: Interpreter) -> None:
    door.command("pause", 0.0)
    door.take(MachineEvent("open"), 1.0)
    door.take(MachineEvent("wind.speed", 7, True), 1.0)
    assert door.state == "shut"
    door.command("step", 1.0)
    assert door.state == "open"
    door.command("step", 1.0)
    assert door.state == "shut"


def test_values_are_forgotten_that_no_active_state_looks_at(door: Interpreter) -> None:
    door.take(MachineEvent("wind.speed", 9, True), 1.0)
    door.take(MachineEvent("open"), 2.0)
    assert (door.state, door.wanted()) == ("open", {"wind.speed"})


def test_a_value_that_is_gone_is_not_known(door: Interpreter) -> None:
    door.edit(machine(DOOR.replace("wind.speed > 5", "not wind.speed > 5")), 0.0)
    door.take(MachineEvent("open"), 1.0)
    door.take(MachineEvent("wind.speed", None, True), 1.0)
    assert door.state == "open"
    door.take(MachineEvent("wind.speed", 1, True), 1.0)
    assert door.state == "shut"


def test_a_failed_set_is_an_event() -> None:
    text = DOOR.replace("( [ sm:when", '( [ sm:on "failed.light" ; sm:to :shut ] [ sm:when')
    door = Interpreter(machine(text))
    door.command("start", 0.0)
    door.take(MachineEvent("open"), 1.0)
    door.fail("light.on", "timeout: no answer", 2.0)
    assert door.state == "shut"
    assert "light.on: timeout: no answer" in [each.text for each in door.log]


def test_what_cannot_be_computed_fails_and_is_not_sent() -> None:
    text = DOOR.replace('"variables.n + 1"', '"light.level + 1"')
    door = Interpreter(machine(text))
    door.command("start", 0.0)
    assert sent(door.take(MachineEvent("open"), 1.0)) == [("light.on", "true")]
    assert ("failed", "fan.speed: not known: light.level + 1") in [e[2:4] for e in door.log]


def test_what_cannot_be_computed_again_and_again_is_in_the_log_once_until_it_can() -> None:
    text = """sm:initial :a . :a a sm:State ; sm:transition [ sm:when "r.x > 9" ; sm:to :a ] ;
    sm:do [ sm:set "r.y" ; sm:expression "r.x + 1" ; sm:every 1.0 ] ."""
    made = Interpreter(machine(text))
    made.command("start", 0.0)
    for now in (1.0, 2.0, 3.0):
        assert made.tick(now) == []
    failed = ("failed", "r.y: not known: r.x + 1")
    assert [e[2:4] for e in made.log].count(failed) == 1
    made.take(MachineEvent("r.x", 1, True), 3.5)
    assert sent(made.tick(4.0)) == [("r.y", "2")]
    made.take(MachineEvent("r.x", None, True), 4.5)
    for now in (5.0, 6.0):
        assert made.tick(now) == []
    assert [e[2:4] for e in made.log].count(failed) == 2


def test_variables_stand_in_texts_and_may_be_got() -> None:
    text = """sm:variable [ sm:name "light" ; sm:value "" ] . :a a sm:State ;
    sm:entry [ sm:set "variables.light" ; sm:get "r.search?type=light" ] ;
    sm:transition [ sm:when "variables.light != \\"\\"" ; sm:to :b ] . :b a sm:State ;
    sm:entry ( [ sm:set "${light}.on" ; sm:value "(${light})" ]
               [ sm:set "files.${light}.jpg" ; sm:get "${light}.image?format=jpeg" ] ) .
    """
    made = Interpreter(machine(f"sm:initial :a ; {text}"))
    (got,) = made.command("start", 0.0)
    assert (got.target, got.get) == ("variables.light", "r.search?type=light")
    first, second = made.assign("light", "home/l1", 1.0)
    assert (first.target, first.value) == ("home/l1.on", "(home/l1)")
    assert (second.target, second.get) == ("files.home/l1.jpg", "home/l1.image?format=jpeg")


def test_final_states_end_what_is_around_them() -> None:
    text = """sm:initial :a . :a a sm:State ; sm:initial :x ; sm:substate :x, :y ;
    sm:transition [ sm:on "done.a" ; sm:to :end ] .
    :x a sm:State ; sm:transition [ sm:on "go" ; sm:to :y ] . :y a sm:Final . :end a sm:Final ."""
    made = Interpreter(machine(text))
    made.command("start", 0.0)
    made.take(MachineEvent("go"), 0.0)
    assert (made.state, made.run) == ("end", "done")
    made.command("start", 1.0)
    assert (made.state, made.run) == ("a.x", "running")


def test_a_machine_that_goes_round_is_paused_and_says_so() -> None:
    text = """sm:initial :a . :a a sm:State ; sm:transition [ sm:to :b ] .
    :b a sm:State ; sm:transition [ sm:to :a ] ."""
    made = Interpreter(machine(text))
    made.command("start", 0.0)
    assert (made.run, made.log[-1].text) == ("paused", "paused: 100 transitions at once")
    made.command("step", 0.0)
    assert made.run == "paused"


@pytest.mark.parametrize("word", ["stop", "pause", "step"])
def test_a_command_that_means_nothing_is_refused(word: str) -> None:
    made = Interpreter(machine(DOOR))
    with pytest.raises(ValueError, match=f"cannot {word}: it is stopped"):
        made.command(word, 0.0)
    assert not made.log


def test_stop_leaves_all_states() -> None:
    made = Interpreter(machine(DOOR))
    made.command("start", 0.0)
    made.take(MachineEvent("open"), 1.0)
    assert sent(made.command("stop", 2.0)) == [("light.on", "false")]
    assert (made.state, made.run, made.take(MachineEvent("open"), 3.0)) == ("", "stopped", [])


Edit = Callable[[Interpreter], None]


def test_an_edit_keeps_state_time_and_variables(door: Interpreter) -> None:
    door.take(MachineEvent("open"), 1.0)
    door.assign("n", 2, 1.0)
    door.edit(machine(DOOR.replace("sm:after 10", "sm:after 4")), 2.0)
    assert (door.state, door.variables, door.next_time()) == ("open", {"n": 2}, 2.5)
    assert door.log[-1].text == "~open"
    door.tick(5.0)
    assert door.state == "shut"


def test_an_edit_that_takes_the_active_state_must_say_where_to_go(door: Interpreter) -> None:
    new = machine(DOOR.replace(":open", ":ajar"))
    door.take(MachineEvent("open"), 1.0)
    before = (door.machine, door.state, len(door.log))
    for goto, why in (("", "say where to go"), ("nowhere", "no state nowhere to go to")):
        with pytest.raises(ValueError, match=why):
            door.edit(new, 2.0, goto)
        assert (door.machine, door.state, len(door.log)) == before
    sends = door.edit(new, 2.0, "ajar")
    assert sent(sends) == [("light.on", "false"), ("light.on", "true"), ("fan.speed", "1")]
    assert door.state == "ajar"


def test_no_more_events_wait_than_there_is_room_for(
    door: Interpreter, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rtkit.services.statemachine.interpreter.MOST_WAITING", 2)
    door.command("pause", 0.0)
    for name in ("x", "y", "z"):
        door.take(MachineEvent(name), 1.0)
    assert [(each.kind, each.text) for each in door.log][-1] == ("lost", "z")
