"""Machines as RDF: Turtle and RDF/XML are read alike; what is wrong is refused whole, by line."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from rdflib import Graph

from rtkit.errors import Refused
from rtkit.resources import resource
from rtkit.services.statemachine.model import BadMachine
from rtkit.services.statemachine.rdf import _WORDS, NAMESPACE, read_machine, write_machine

PATROL = (Path(__file__).parent / "patrol.ttl").read_text(encoding="utf-8")

NODELESS = """@prefix sm: <urn:rtkit:statemachine#> .
<#m> a sm:Machine ; sm:initial <#a> .
"""


@pytest.mark.filterwarnings("ignore:Assertions on")
def test_turtle_and_rdf_xml_say_the_same() -> None:
    graph = Graph().parse(data=PATROL, publicID="file:///machine")
    for form in ("xml", "pretty-xml"):
        assert read_machine(graph.serialize(format=form)) == read_machine(PATROL)


def test_a_machine_has_all_that_its_text_says() -> None:
    machine = read_machine(PATROL)
    assert [*machine.states] == ["wait", "patrol", "patrol.out", "patrol.back", "end"]
    assert (machine.name, machine.doc) == ("home", "A robot goes to and fro.")
    assert (machine.initial, machine.variables) == ("wait", {"laps": 0})
    assert machine.states["patrol.out"].do[0].every == 0.3
    assert machine.states["end"].is_final
    assert [way.cause for way in machine.states["patrol"].transitions] == [
        "when variables.laps >= 3",
        "after 30",
    ]


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        (":back ]", ":bakc ]", "line 26: patrol.out: no state to go to: bakc"),
        ("laps >=", "lapz >=", "line 20: patrol: no variable lapz; did you mean laps?"),
        ('"variables.laps" ;', '"variables.lap" ;', "line 29: patrol.back: no variable lap;"),
        ('"light.on" ; sm:value "true"', '"${x}.on" ; sm:value "true"', "line 19: patrol: no var"),
        ("sm:entry [ sm:set", "sm:entri [ sm:set", "line 12: not known here: sm:entri; did you"),
        ("x > 1", "x >", "line 26: sm:when: column 23: did not expect the end: robots/r1"),
        ("sm:initial :out", "sm:initial :end", "line 17: initial state of patrol is none of"),
        ("sm:initial :wait", "sm:initial :wiat", "line 8: initial state of the machine is none"),
        ("a sm:Final", "a sm:Finl", "line 32: not expected here: sm:Finl"),
        ("after 30", 'after "soon"', "line 21: sm:after: expected seconds, found soon"),
        ("after 30", "after -1", "line 21: sm:after: expected seconds"),
        ("every 0.3", "every 0", "line 25: sm:every: expected more than 0 s"),
        ("sm:Final .", "sm:Final", "line 33: EOF found"),
        (":out a sm:State", ":out a sm:Action", "line 24: not expected here: sm:Action"),
        (":out, :back", ":out, :back, :patrol", "line 16: state patrol is inside itself"),
        ('sm:set "light.on" ; sm:value "true"', 'sm:set "light.on"', "line 19: an action is"),
        ("sm:to :wait", 'sm:to "wait"', "line 21: sm:to: expected a state"),
        ("[ sm:after 30 ; sm:to :wait ]", "[ sm:after 30 ]", "line 21: a transition says sm:to"),
        (":end a sm:Final", ":x sm:when 1 . :end a sm:Final", "line 32: sm:when of nothing that"),
        (":end a sm:Final", ":meta a sm:Final", "line 32: not a name of a state: meta"),
        ("sm:entry [ sm", "sm:entry [ sm:raise 1 ], [ sm", "line 12: sm:entry is there twice"),
        ('sm:name "laps"', 'sm:name "la ps"', "line 9: a variable has sm:name and sm:value"),
        ("0 ] .", '0 ], [ sm:name "laps" ; sm:value 0 ] .', "line 9: variable laps is there twice"),
        (":home a sm:Machine", ":home a sm:State", "line 1: expected one sm:Machine, found 0"),
        (":wait a", ":home sm:state :b . :wait a", "line 11: not known here: sm:state; did you"),
    ],
)
def test_a_bad_machine_is_refused_with_the_line(old: str, new: str, why: str) -> None:
    assert old in PATROL
    with pytest.raises(BadMachine) as refused:
        read_machine(PATROL.replace(old, new, 1))
    assert str(refused.value).startswith(why), refused.value


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "line 1: expected one sm:Machine, found 0"),
        ("hello", "line 1: expected directive"),
        ("?", "line 1: not Turtle"),
        ("@prefix", "line 1: not Turtle"),
        ("@prefix : <#> .\n\n:a sm:b :c .", 'line 3: Prefix "sm:" not bound'),
        ("<?xml version='1.0'?>\n<a", "line 2: "),
        (
            '<?xml version="1.0"?>\n<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><a/>',
            "line 2:",
        ),
        ("@prefix sm: <urn:rtkit:statemachine#> .\n" + "[ sm:to " * 5000, "line "),
        ("@prefix sm: <urn:rtkit:statemachine#> .\n<#a> sm:entry ?x .", "line 2: "),
        ('@prefix sm: <urn:rtkit:statemachine#> .\n<#a> sm:on "\\u0001" .', "line 2: control"),
        (NODELESS + '<#a> a sm:State ;\nsm:entry ( "x" ) .', "line 4: an action is"),
        (NODELESS + "<#a> a sm:State ; sm:transition <#z> .", "line 3: a transition says"),
        (
            f"""{NODELESS}<#a> a sm:State ;
            sm:transition [ sm:when "{"(" * 199}" ; sm:to <#a> ] .""",
            "line 4: sm:when: ",
        ),
        (
            "<?xml version='1.0'?>\n<rdf:RDF xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'"
            " xmlns:a='x:'>\n<rdf:Description><a:b rdf:parseType='Collection'><rdf:li/></a:b>"
            "</rdf:Description></rdf:RDF",
            "line 3: ",
        ),
    ],
)
def test_what_is_no_machine_is_refused_with_the_line(text: str, why: str) -> None:
    with pytest.raises(BadMachine) as refused:
        read_machine(text)
    assert str(refused.value).startswith(why), refused.value


def test_a_transition_may_only_act() -> None:
    way = '[ sm:when "a.b > 1" ; sm:action [ sm:raise "x" ] ]'
    machine = read_machine(f"{NODELESS}<#a> a sm:State ; sm:transition {way} .")
    (made,) = machine.states["a"].transitions
    assert (made.to, made.on, made.actions[0].target) == ("", "", "x")
    assert read_machine(write_machine(machine)) == machine


def test_a_machine_may_name_its_outermost_states() -> None:
    machine = read_machine(f"{NODELESS}<#m> sm:substate <#a> .\n<#a> a sm:State .")
    assert list(machine.states) == ["a"]


def test_states_inside_each_other_in_a_ring_are_refused() -> None:
    text = PATROL + ":p a sm:State ; sm:substate :q .\n:q a sm:State ; sm:substate :p .\n"
    with pytest.raises(BadMachine, match="line 33: state p is inside itself"):
        read_machine(text)


def test_a_list_without_end_is_refused() -> None:
    ring = "_:l <http://www.w3.org/1999/02/22-rdf-syntax-ns#first> [ sm:raise 1 ] ; "
    ring += "<http://www.w3.org/1999/02/22-rdf-syntax-ns#rest> _:l .\n:end sm:entry _:l ."
    with pytest.raises(BadMachine):
        read_machine(PATROL + ring)


def test_a_machine_can_be_put_into_another_as_a_state() -> None:
    machine = read_machine(PATROL)
    made = read_machine(PATROL, machine, "patrol.inner")
    assert made.states["patrol.inner"].initial == "patrol.inner.wait"
    assert made.states["patrol.inner.patrol.out"].transitions[0].to == "patrol.inner.patrol.back"


def test_a_state_that_is_put_elsewhere_hears_of_its_own_ends() -> None:
    ends = '[ sm:on "done.patrol.out" ; sm:action [ sm:raise "done.patrol" ] ] [ sm:on "done.end" ;'
    text = PATROL.replace("[ sm:after 30 ;", f"{ends} sm:to :wait ] [ sm:after 30 ;")
    machine = read_machine(text)
    made = read_machine(write_machine(machine, "patrol"), machine, "wait")
    _, first, second, _ = made.states["wait"].transitions
    assert (first.on, first.actions[0].target) == ("done.wait.out", "done.wait")
    assert second.on == "done.end", "of a state that stays where it was"


def test_a_state_that_is_kept_has_the_variables_that_it_uses() -> None:
    text = f"""{NODELESS}<#a> a sm:State ; sm:initial <#b> ; sm:substate <#b> ; sm:variable
        [ sm:name "seen" ; sm:value "no" ], [ sm:name "laps" ; sm:value 3 ],
        [ sm:name "last" ; sm:value 0.5 ], [ sm:name "other" ; sm:value 7 ] .
    <#b> a sm:State ; sm:exit [ sm:set "x.y" ; sm:value "${{seen}}" ] ; sm:transition
        [ sm:when "variables.laps > 1" ; sm:action [ sm:set "variables.last" ; sm:value 1 ] ] ."""
    part = write_machine(read_machine(text), "a")
    host = read_machine(f"{NODELESS}<#a> a sm:State .")
    assert read_machine(part, host, "a.new").variables == {"seen": "no", "laps": 3, "last": 0.5}
    kept = read_machine(part, host._replace(variables={"laps": 9}), "a.new").variables
    assert kept == {"seen": "no", "laps": 9, "last": 0.5}, "its own stay"
    assert "variable" not in write_machine(host, "a")
    with pytest.raises(BadMachine, match="variable laps is there twice"):
        read_machine(part.replace('"last"', '"laps"', 1), host, "a.new")


@pytest.mark.parametrize("name", ["m", "two words", "a.b", "<#x>", "é/1", 'q"u'])
def test_a_machine_keeps_its_name(name: str) -> None:
    machine = read_machine(f"{NODELESS}<#a> a sm:State .")._replace(name=name)
    assert read_machine(write_machine(machine)).name == name


@pytest.mark.parametrize(
    ("at", "why"),
    [("nowhere.x", "no state nowhere to put it into"), ("a b", "line 23: not a name of a state")],
)
def test_a_state_is_not_put_anywhere(at: str, why: str) -> None:
    machine = read_machine(PATROL)
    with pytest.raises(BadMachine) as refused:
        read_machine(
            write_machine(machine, "patrol.out").replace("@", "\n" * 19 + "@", 1), machine, at
        )
    assert str(refused.value).startswith(why), refused.value


def test_a_missing_library_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rdflib", None)
    with pytest.raises(Refused, match=r"pip install 'rtkit\[rdf\]'"):
        read_machine(PATROL)


def test_the_vocabulary_has_every_word_that_is_read() -> None:
    graph = Graph().parse(resource("schemas", "statemachine.ttl"))
    told = {
        str(each).removeprefix(NAMESPACE) for each in graph.subjects() if NAMESPACE in str(each)
    }
    words = {word for each in _WORDS.values() for word in each}
    kinds = {"Machine", "State", "Final", "Transition", "Action", "Variable"}
    assert told == words | kinds


@pytest.mark.parametrize("value", ["", "two words", 'a "b"', "inf.", "x"])
def test_text_variables_are_read_as_they_were_written(value: str) -> None:
    machine = read_machine(f"{NODELESS}<#a> a sm:State .")._replace(variables={"v": value})
    assert read_machine(write_machine(machine)).variables == {"v": value}
