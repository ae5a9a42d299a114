"""Drafts of state machines: what a record means, all that is wrong in it, and where it is drawn."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest

from rtkit.errors import Malformed
from rtkit.services.statemachine.rdf import read_machine
from rtkit.web.machines.drafts import draft_of, record_of
from rtkit.web.machines.machine_layout import machine_layout

PATROL = Path(__file__).parents[1] / "services" / "statemachine" / "patrol.ttl"


def patrol() -> dict[str, Any]:
    return record_of(read_machine(PATROL.read_text(encoding="utf-8")))


def state(record: dict[str, Any], path: str) -> dict[str, Any]:
    return next(each for each in record["states"] if each["path"] == path)


def faults(record: dict[str, Any]) -> list[tuple[str, str]]:
    return [(each.state, each.part) for each in draft_of(record).problems if not each.is_odd]


def test_a_record_means_the_machine_it_was_made_of() -> None:
    draft = draft_of(patrol())
    assert draft.machine == read_machine(PATROL.read_text(encoding="utf-8"))
    assert (draft.problems, draft.is_whole) == ((), True)


def test_all_that_is_wrong_is_told_at_once_with_its_place() -> None:
    record = patrol()
    record["initial"] = ""
    record["variables"].append(copy.deepcopy(record["variables"][0]))
    state(record, "patrol")["initial"] = "wait"
    wait = state(record, "wait")
    wait["transitions"][0] |= {"to": "patrl", "when": "1 >", "after": "soon"}
    wait["entry"] = [{"kind": "assign", "target": "lap", "how": "expression", "value": "1"}]
    wait["do"] = [{"kind": "set", "target": "", "how": "get", "value": "", "every": "0"}]
    state(record, "end")["transitions"] = [{"to": "wait", "on": "again"}]
    record["states"].append({"path": "meta"})
    record["states"].append({"path": "meta"})
    draft = draft_of(record)
    assert not draft.is_whole
    assert sorted(faults(record)) == sorted(
        [
            ("", "variables"),
            ("", "initial"),
            ("patrol", "initial"),
            ("wait", "transitions.0"),
            ("wait", "transitions.0"),
            ("wait", "transitions.0"),
            ("wait", "entry.0"),
            ("wait", "do.0"),
            ("wait", "do.0"),
            ("wait", "do.0"),
            ("end", "is_final"),
            ("meta", "name"),
            ("meta", "name"),
        ]
    )
    assert "did you mean patrol?" in " ".join(each.text for each in draft.problems)
    assert machine_layout(draft.machine)["boxes"].keys() >= {"wait", "patrol.out"}


def test_odd_things_are_told_and_may_be_put_in_force() -> None:
    record = patrol()
    wait = state(record, "wait")
    wait["transitions"] += [{"to": "end", "on": "go"}, {"to": "end", "on": "go", "when": "1 > 0"}]
    record["states"].append({"path": "lost", "transitions": [{"to": "end"}]})
    draft = draft_of(record)
    assert draft.is_whole
    assert [(each.state, each.part) for each in draft.problems] == [
        ("wait", "transitions.1"),
        ("wait", "transitions.2"),
        ("lost", "name"),
    ]


@pytest.mark.parametrize(
    ("record", "why"),
    [
        (None, "machine: an object is wanted"),
        ({"states": {}}, "states: a list is wanted"),
        ({"states": [{"path": 1}]}, "path: a text is wanted"),
        ({"states": [{"path": "a", "entry": [{"kind": "do"}]}]}, "kind: set or assign or raise"),
    ],
)
def test_what_is_no_record_is_refused(record: Any, why: str) -> None:
    with pytest.raises(Malformed, match=why):
        draft_of(record)


def test_no_state_and_no_name_are_told() -> None:
    assert faults({"name": " ", "states": []}) == [("", "name"), ("", "states")]


def test_states_are_drawn_inside_each_other_and_transitions_begin_at_their_rows() -> None:
    record = patrol()
    state(record, "patrol")["transitions"].append({"to": "patrol.back", "on": "turn"})
    layout = machine_layout(draft_of(record).machine)
    outer, inner = layout["boxes"]["patrol"], layout["boxes"]["patrol.out"]
    assert (outer["kind"], inner["kind"], inner["parent"]) == ("composite", "state", "patrol")
    assert outer["rows"] == ["[variables.laps >= 3]", "after 30 s", "turn → patrol.back"]
    lowest_row = outer["y"] + outer["head"] + 20 * len(outer["rows"])
    assert lowest_row <= inner["y"]
    assert inner["y"] + inner["height"] <= outer["y"] + outer["height"]
    assert inner["x"] >= outer["x"]
    start = layout["paths"]["patrol#1"][0]
    assert start == (outer["x"] + outer["width"], outer["y"] + outer["head"] + 30)
    end = layout["paths"]["patrol#0"][-1]
    final = layout["boxes"]["end"]
    assert end == (final["x"], final["y"] + final["head"] + 10)
    assert "patrol#2" not in layout["paths"], "it leads inside: its row says where"


def test_the_initial_state_is_leftmost_also_in_a_circle() -> None:
    names = ["a", "b", "c"]
    states = [
        {"path": name, "transitions": [{"to": names[(at + 1) % 3], "on": "go"}]}
        for at, name in enumerate(names)
    ]
    for first in names:
        record = {"name": "m", "initial": first, "states": states}
        boxes = machine_layout(draft_of(record).machine)["boxes"]
        assert min(boxes, key=lambda path: boxes[path]["x"]) == first
