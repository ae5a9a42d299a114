"""State machines as tables."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.component.state_table import StateTable, lineage
from rtkit.errors import Malformed, NotFound

OVEN = {
    "On.Idle": {"minute": "On.Set", "stop": "On.Idle"},
    "On.Set": {"start": "On.Cook"},
    "On.Cook": {"stop": "On"},
    "On": {"open": "Off", "again": "On"},
    "Off": {"close": "On", "deep": "On.Cook"},
}


@pytest.fixture
def oven():
    return StateTable(OVEN)


def test_outer_states_that_are_implied_are_there(oven):
    assert list(oven.table) == ["On", "On.Idle", "On.Set", "On.Cook", "Off"]
    assert oven.table["On"] == {"open": "Off", "again": "On"}
    assert StateTable({"a.b.c": {}}).table == {"a": {}, "a.b": {}, "a.b.c": {}}


def test_it_begins_in_the_first_state_inside_the_first(oven):
    assert oven.initial == "On.Idle"
    assert oven.beginning().entered == ("On", "On.Idle")
    assert oven.beginning().exited == ()


def test_events_are_known_to_a_state_and_to_those_around_it(oven):
    assert oven.target("On.Idle", "minute") == "On.Set"
    assert oven.target("On.Cook", "open") == "Off"
    assert oven.target("On.Cook", "minute") is None
    assert oven.events == ("open", "again", "minute", "stop", "start", "close", "deep")


@pytest.mark.parametrize(
    ("source", "target", "exited", "entered", "end"),
    [
        ("On.Idle", "On.Set", ["On.Idle"], ["On.Set"], "On.Set"),
        ("On.Cook", "Off", ["On.Cook", "On"], ["Off"], "Off"),
        ("Off", "On", ["Off"], ["On", "On.Idle"], "On.Idle"),
        ("Off", "On.Cook", ["Off"], ["On", "On.Cook"], "On.Cook"),
        ("On.Idle", "On.Idle", ["On.Idle"], ["On.Idle"], "On.Idle"),
        ("On.Cook", "On", ["On.Cook", "On"], ["On", "On.Idle"], "On.Idle"),
    ],
)
def test_what_is_left_and_entered(oven, source, target, exited, entered, end):
    move = oven.move(source, "e", target)
    assert (list(move.exited), list(move.entered), move.target) == (exited, entered, end)


@pytest.mark.parametrize(
    ("table", "why"),
    [
        ({}, "needs a state"),
        ({"A": {"go": "B"}}, "event go leads to no state: B"),
        ({"A": {"": "A"}}, "an event without a name"),
        ({"A..B": {}}, "not a name of a state"),
        ({"": {}}, "not a name of a state"),
        ({"A": {"x\ty": "A"}}, "an event without a name"),
    ],
)
def test_tables_that_are_none(table, why):
    with pytest.raises(Malformed, match=why):
        StateTable(table)


def test_a_state_that_is_not_there(oven):
    with pytest.raises(NotFound, match=r"no state Nowhere; there are On, On\.Idle"):
        oven.move("On.Idle", "e", "Nowhere")


NAMES = st.recursive(
    st.sampled_from("ABC"), lambda inner: st.tuples(inner, st.sampled_from("ABC")).map(".".join)
)


@st.composite
def machines(draw):
    states = draw(st.lists(NAMES, min_size=1, max_size=6, unique=True))
    known = sorted({each for state in states for each in lineage(state)})
    moves = st.dictionaries(st.sampled_from("xyz"), st.sampled_from(known), max_size=3)
    return StateTable({state: draw(moves) for state in states})


@given(machines(), st.lists(st.sampled_from("xyz"), max_size=12))
def test_entering_and_leaving_always_add_up(machine, events):
    inside = list(machine.beginning().entered)
    state = machine.initial
    for event in events:
        target = machine.target(state, event)
        if target is None:
            continue
        move = machine.move(state, event, target)
        for left in move.exited:
            assert inside.pop() == left
        inside += move.entered
        state = move.target
        assert inside == list(reversed(list(lineage(state))))
        assert machine.innermost(state) == state
        assert target in inside


@given(machines())
def test_a_table_that_was_completed_is_complete(machine):
    assert StateTable(machine.table).table == machine.table
    assert StateTable(machine.table).initial == machine.initial
