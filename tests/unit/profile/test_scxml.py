"""State machines as SCXML."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.profile.findings import InvalidProfile
from rtkit.profile.scxml import read_scxml, write_scxml

OVEN = {
    "On": {"open": "Off"},
    "On.Idle": {"minute": "On.Set"},
    "On.Set": {"start": "On.Set", "stop": "On.Idle"},
    "Off": {"close": "On"},
}
TEXT = """\
<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" name="Oven" initial="On">
    <state id="On" initial="Idle">
        <transition event="open" target="Off"/>
        <state id="Idle">
            <transition event="minute" target="Set"/>
        </state>
        <state id="Set">
            <transition event="start" target="Set"/>
            <transition event="stop" target="Idle"/>
        </state>
    </state>
    <state id="Off">
        <transition event="close" target="On"/>
    </state>
</scxml>
"""


def chart(body: str, attributes: str = ""):
    text = f'<scxml xmlns="http://www.w3.org/2005/07/scxml" {attributes}>\n{body}</scxml>'
    return read_scxml(text.encode(), "m.scxml")


def test_a_table_as_text():
    assert write_scxml("Oven", OVEN) == TEXT


def test_a_text_as_table():
    read = read_scxml(TEXT.encode())
    assert (read.name, read.states, read.notes) == ("Oven", OVEN, ())
    assert list(read.states) == list(OVEN)


def test_the_initial_state_comes_first_at_every_level():
    body = '<state id="B"/><state id="A"><initial><transition target="D"/></initial>'
    body += '<state id="C"/><state id="D"/></state>'
    assert list(chart(body, 'initial="A"').states) == ["A", "A.D", "A.C", "B"]


def test_names_that_are_not_unique_are_written_in_full():
    states = {"X": {}, "X.A": {"go": "Y.A"}, "Y": {}, "Y.A": {"go": "X.A"}}
    text = write_scxml("M", states)
    assert 'id="X.A"' in text
    assert read_scxml(text.encode()).states == states


def test_several_events_of_one_transition():
    body = '<state id="A"><transition event="x y" target="A"/></state>'
    assert chart(body).states == {"A": {"x": "A", "y": "A"}}


def test_what_is_the_code_s_own_is_noted_and_left_out():
    body = '<datamodel/>\n<state id="A">\n<onentry><log expr="1"/></onentry></state>'
    read = chart(body)
    assert read.states == {"A": {}}
    assert [(n.line, n.text) for n in read.notes][:2] == [
        (2, "datamodel is left out"),
        (4, "onentry is left out"),
    ]


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("", "there is no state"),
        ('<parallel id="P"/><state id="A"/>', "parallel is not supported"),
        ('<state id="A"><history id="H"/></state>', "history is not supported"),
        ("<state/>", "a state without id"),
        ('<state id="A"/><state id="A"/>', "state A is there twice"),
        ('<state id="a.b"/><state id="a_b"/>', "state a_b is there twice"),
        ('<state id="A" initial="B"/>', "initial is none of the states inside: B"),
        ('<state id="A"><transition event="x" target="B"/></state>', "no state B to go to"),
        ('<state id="A"><transition event="x"/></state>', r"no state \(none\) to go to"),
        ('<state id="A"><transition target="A"/></state>', "a transition without event"),
        (
            '<state id="A"><transition event="x" cond="y" target="A"/></state>',
            "a transition with a condition",
        ),
    ],
)
def test_what_is_not_supported_is_told_with_its_line(body, why):
    with pytest.raises(InvalidProfile, match=f"m.scxml:[12]: {why}"):
        chart(body)


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"<scxml/>",
        b'<!DOCTYPE scxml [<!ENTITY e "x">]><scxml xmlns="http://www.w3.org/2005/07/scxml"/>',
        b"<a><b></a>",
    ],
)
def test_documents_that_are_none(text):
    with pytest.raises(InvalidProfile):
        read_scxml(text)


def test_a_document_without_namespace_is_told_which_one_it_needs():
    with pytest.raises(InvalidProfile, match="the root is in no namespace: <scxml"):
        read_scxml(b'<scxml initial="A"><state id="A"/></scxml>')


PARTS = st.sampled_from(["A", "B", "Long name", "Zürich", "<&>"])
PATHS = st.recursive(PARTS, lambda inner: st.tuples(inner, PARTS).map(".".join), max_leaves=3)


@st.composite
def tables(draw):
    names = draw(st.lists(PATHS, min_size=1, max_size=5, unique=True))
    every: dict[str, dict[str, str]] = {}
    for name in sorted(names):
        parts = name.split(".")
        for count in range(1, len(parts) + 1):
            every.setdefault(".".join(parts[:count]), {})
    targets = st.sampled_from(list(every))
    events = st.sampled_from(["go", "e.x", "ümläut", "<"])
    return {name: draw(st.dictionaries(events, targets, max_size=2)) for name in every}


@given(tables())
def test_what_is_written_is_read(states):
    assert read_scxml(write_scxml("M", states).encode()).states == states
