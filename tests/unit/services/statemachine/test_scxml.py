"""SCXML: the subset that is read, the rest that is refused by line, what is written."""

from __future__ import annotations

import itertools
import re
import time
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from rtkit.services.statemachine.interpreter import Interpreter, MachineEvent
from rtkit.services.statemachine.model import BadMachine
from rtkit.services.statemachine.picture import draw_machine
from rtkit.services.statemachine.rdf import read_machine, write_machine
from rtkit.services.statemachine.scxml import NAMESPACE, read_scxml, write_scxml

HERE = Path(__file__).parent
TURNSTILE = (HERE / "scxml" / "turnstile.scxml").read_text(encoding="utf-8")
NESTED = (HERE / "scxml" / "nested.scxml").read_text(encoding="utf-8")


def test_events_lead_on() -> None:
    made = Interpreter(read_scxml(TURNSTILE))
    made.command("start", 0.0)
    visited = []
    for event in ("push", "coin.foreign", "push", "coin", "push", "kick.hard"):
        made.take(MachineEvent(event), 0.0)
        visited.append(made.state)
    assert visited == ["locked", "unlocked", "locked", "unlocked", "locked", "broken"]
    assert made.run == "done"


def test_conditions_actions_and_time_outs_are_read() -> None:
    made = Interpreter(read_scxml(NESTED))
    (on,) = made.command("start", 0.0)
    assert (made.state, on.target, on.value, made.next_time()) == (
        "work.fast",
        "light.on",
        "true",
        1.5,
    )
    made.take(MachineEvent("meter.value", 4, True), 1.0)
    assert (made.state, made.variables) == ("work.slow", {"count": 1})
    (off,) = made.tick(1.5)
    assert (made.state, off.value) == ("rest", "false")


@pytest.mark.parametrize("text", [TURNSTILE, NESTED])
def test_what_was_read_is_written_and_read_alike(text: str) -> None:
    written = write_scxml(read_scxml(text))
    assert write_scxml(read_scxml(written)) == written


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('<state id="rest"/>', '<parallel id="rest"/>', "line 26: not read here: parallel"),
        ('<state id="rest"/>', '<state id="rest"><history id="h"/></state>', "line 26: not read"),
        ('<raise event="slower"/>', "<script>x()</script>", "line 22: not read here: script"),
        ('<raise event="slower"/>', '<if cond="1"/>', "line 22: not read here: if"),
        ('target="rest"', 'target="bed"', "line 17: work: no state to go to: bed"),
        ('target="fast"', 'target="rest"', "line 5: initial state of work is none of those"),
        ("variables.count &lt;", "variables.cont &lt;", "line 19: work.fast: no variable cont"),
        ("meter.value &gt;", "alert(1) &gt;", "line 20: column 6: did not expect (: alert(1) >"),
        ('datamodel="rtkit"', 'datamodel="ecmascript"', "line 20: expressions are read where"),
        ('event="late" target', 'event="soon" target', "line 5: no transition of work takes the"),
        ('delay="1500ms"', 'delay="soon"', "line 11: a send is a SET"),
        ("<content>true</content>", "<content><b/></content>", "line 10: not read here: b"),
        ('id="slow"', 'id="fast"', "line 19: not a new id of a state: fast"),
        ('id="slow"', 'id="properties"', "line 18: not a new id of a state: properties"),
        ('<state id="rest"/>', '<state id="a.b"/><state id="a_b"/>', "line 26: not a new id of"),
        ('target="fast"/>', 'target="fast"><raise event="x"/></transition>', "line 7: an initial"),
        ('event="late" target', 'type="internal" event="late" target', "line 17: not read here: a"),
        ('<raise event="slower"/>', '<cancel sendid="late"/>', "line 22: a cancel of a delayed"),
        ('<raise event="slower"/>', "<raise/>", "line 22: a raise has an event"),
        (
            'id="late" delay',
            'delay="1s"/><send event="late" delay',
            "line 11: the delayed event l",
        ),
        ('id="late" delay', 'target="x" delay', "line 11: a send is a SET"),
        ('target="light.on"', 'target="light.on" delay="1s"', "line 10: a send is a SET"),
        (
            'target="light.on"',
            'targetexpr="light.on"',
            "line 10: not read here: send with",
        ),
        ('expr="0"', 'src="file:///etc/passwd"', "line 3: not read here: data with src"),
        ('expr="0"', 'expr="meter.value"', "line 3: not a number, true, false or a text"),
        ('expr="0"', 'expr="1 +"', "line 3: column 4: did not expect the end"),
        ('<data id="count"', '<data id="my count"', "line 3: not a new id of a variable: my count"),
        ("</datamodel>", "<script/></datamodel>", "line 4: not read here: script"),
        ('<state id="rest"/>', '<x xmlns="urn:x"/>', "line 26: not read here: {urn:x}x"),
        ("</scxml>", "", "line 28: Premature end"),
        ("http://www.w3.org/2005/07/scxml", "urn:x", "line 1: the root is not scxml of xmlns="),
    ],
)
def test_what_is_not_in_the_subset_is_refused_by_line(old: str, new: str, why: str) -> None:
    assert old in NESTED
    with pytest.raises(BadMachine) as refused:
        read_scxml(NESTED.replace(old, new, 1))
    assert str(refused.value).startswith(why), refused.value


def test_an_error_of_the_parser_names_its_line_once() -> None:
    with pytest.raises(BadMachine) as refused:
        read_scxml("<scxml")
    assert str(refused.value) == "line 1: Couldn't find end of Start Tag scxml"
    with pytest.raises(BadMachine) as refused:
        read_scxml("<scxml>\n<a>\n</b>\n</scxml>")
    assert str(refused.value) == "line 3: Opening and ending tag mismatch: a line 2 and b"


def test_a_transition_that_only_acts_goes_both_ways() -> None:
    acts = '<transition cond="meter.value &gt; 5"><raise event="x"/></transition>'
    later = '<transition event="late"><raise event="y"/></transition>'
    text = NESTED.replace('<transition event="late"', f'{acts}{later}<transition event="late"', 1)
    old, new = '<transition event="late" target', '<transition event="l" target'
    machine = read_scxml(text.replace(old, new))
    made = [each for each in machine.states["work"].transitions if not each.to]
    assert [(each.on, each.after, each.actions[0].target) for each in made] == [
        ("", None, "x"),
        ("", 1.5, "y"),
    ]
    assert read_machine(write_machine(machine)).states == machine.states
    assert read_scxml(write_scxml(read_machine(write_machine(machine)))).states == machine.states
    with pytest.raises(BadMachine, match="line 17: a transition has a target, an event or actions"):
        read_scxml(NESTED.replace('<transition event="late" target="rest"/>', "<transition/>"))


def test_the_end_of_a_state_is_the_event_that_scxml_knows() -> None:
    ending = '<transition event="done.state.work push" target="rest"/><final id="gone"/>'
    text = NESTED.replace('<transition event="late"', f'{ending}<transition event="late"', 1)
    machine = read_scxml(text.replace('target="slow"', 'target="gone"'))
    assert [each.on for each in machine.states["work"].transitions] == ["done.work", "push", ""]
    assert 'event="done.state.work"' in write_scxml(machine)
    made = Interpreter(machine)
    made.command("start", 0.0)
    made.take(MachineEvent("meter.value", 4, True), 1.0)
    assert made.state == "rest"


def test_a_set_of_a_variable_assigns_it() -> None:
    text = NESTED.replace('target="light.on"', 'target="variables.count"', 1)
    machine = read_scxml(text)
    made = Interpreter(machine)
    assert made.command("start", 0.0) == []
    assert made.variables == {"count": True}
    assert read_machine(write_machine(machine)) == machine


def test_a_delayed_event_may_be_taken_by_several_transitions() -> None:
    several = '<transition event="late" cond="variables.count = 1" target="slow"/>'
    text = NESTED.replace('<transition event="late"', f'{several}<transition event="late"', 1)
    first, second = read_scxml(text).states["work"].transitions
    assert (first.after, second.after, first.on, second.on) == (1.5, 1.5, "", "")
    made = Interpreter(read_scxml(text))
    made.command("start", 0.0)
    made.tick(1.5)
    assert made.state == "rest"


@pytest.mark.parametrize(
    ("text", "value"),
    [('expr="-1.5"', -1.5), ('expr="true"', True), ('expr="&quot;a b&quot;"', "a b"), ("", 0)],
)
def test_variables_begin_with_what_is_written(text: str, value: object) -> None:
    machine = read_scxml(NESTED.replace('expr="0"', text))
    assert machine.variables == {"count": value}
    assert read_scxml(write_scxml(machine)).variables == {"count": value}


def test_a_value_may_be_the_text_of_an_element() -> None:
    text = NESTED.replace('<data id="count" expr="0"/>', '<data id="count"> 3 </data>')
    assert read_scxml(text).variables == {"count": 3}


def test_many_states_are_read_in_no_time() -> None:
    states = "".join(f'<state id="s{n}"/>' for n in range(10_000))
    head = f'<scxml xmlns="http://www.w3.org/2005/07/scxml">{states}</scxml>'
    begun = time.process_time()
    assert len(read_scxml(head).states) == 10_000
    assert time.process_time() - begun < 3.0


def test_entities_are_refused() -> None:
    bomb = '<!DOCTYPE scxml [<!ENTITY x SYSTEM "file:///etc/passwd">]>'
    with pytest.raises(BadMachine, match="a DOCTYPE is refused"):
        read_scxml(bomb + NESTED.replace("true", "&x;"))


def test_what_scxml_cannot_say_is_noted() -> None:
    written = write_scxml(read_machine((HERE / "patrol.ttl").read_text(encoding="utf-8")))
    assert "<!-- do robots/r1.velocity every 0.3 s -->" in written


def test_the_picture_has_every_state_and_cause() -> None:
    machine = read_machine((HERE / "patrol.ttl").read_text(encoding="utf-8"))
    root = ET.fromstring(draw_machine(machine, "patrol.out"))
    space = "{http://www.w3.org/2000/svg}"
    texts = ["".join(each.itertext()) for each in root.iter(f"{space}text")]
    assert {"● wait", "patrol", "● out", "back", "end ◉"} <= set(texts)
    assert sum("when robots/r1.location.x > 1" in each for each in texts) == 1
    boxes = [each.get("class") for each in root.iter(f"{space}rect")]
    assert boxes == ["state", "state active", "state active", "state", "state"]
    ways = [each for each in root.iter(f"{space}path") if each.get("class") == "way"]
    told = {"".join(each.itertext()) for each in ways}
    assert {"patrol.out → patrol.back", "wait → patrol"} <= told
    assert len({each.get("d") for each in ways}) == len(ways) == 5


def test_no_way_of_a_picture_lies_on_another() -> None:
    states = "".join(
        f'<state id="s{each}"><transition event="a" target="s{each * 7 % 9}"/>'
        f'<transition event="b" target="s{each * 5 % 9}"/></state>'
        for each in range(9)
    )
    document = f'<scxml xmlns="{NAMESPACE}" name="m">{states}</scxml>'
    root = ET.fromstring(draw_machine(read_scxml(document)._replace(name="<m>")))
    parts: dict[float, list[tuple[float, float]]] = {}
    for each in root.iter("{http://www.w3.org/2000/svg}path"):
        if each.get("class") == "way":
            _, start, x, end, _ = (float(n) for n in re.findall(r"[\d.]+", each.get("d") or ""))
            parts.setdefault(x, []).append((min(start, end), max(start, end)))
    for lane in map(sorted, parts.values()):
        assert all(one[1] < other[0] for one, other in itertools.pairwise(lane))
