"""What users asked of components since they were made, told by a process and read by a manager."""

from __future__ import annotations

from typing import Any

import pytest

from rtkit.container.user_requests import UserRequests
from rtkit.deployment import actions as act
from rtkit.errors import Malformed
from rtkit.manager.core.desired import DesiredComponent
from rtkit.manager.core.desired_changes import desired_by, requests_from


def asked(*messages: dict[str, Any]) -> UserRequests:
    noted = UserRequests()
    for message in messages:
        noted.note({"instance": "A", "call": 7, **message})
    return noted


def desired(noted: UserRequests) -> DesiredComponent:
    return desired_by("A", requests_from(noted.by_component(["A"]))["A"])


def test_the_last_request_of_each_kind_counts_and_values_add_up() -> None:
    noted = asked(
        {"op": "set", "set_id": "s", "values": {"a": "1", "b": "1"}},
        {"op": "set", "set_id": "s", "values": {"a": "2"}},
        {"op": "set", "set_id": "t", "values": {"a": "9"}},
        {"op": "activate_set", "set_id": "t"},
        {"op": "activate_set", "set_id": "s"},
        {"op": "change_state", "context": "0", "transition": "activate", "wait": False, "until": 1},
        {"op": "change_state", "context": "1", "transition": "activate"},
        {"op": "change_state", "context": "1", "transition": "deactivate"},
        {"op": "set_rate", "context": "0", "rate": 5.0},
        {"op": "attach", "context": "0", "participant": "B"},
        {"op": "attach", "context": "0", "participant": "C"},
        {"op": "detach", "context": "0", "participant": "C"},
        {"op": "set_structure", "states": {"s": {"e": "s"}}},
        {"op": "set_events", "events": {"e": "TimedLong"}},
        {"op": "tick", "context": "0"},
    )
    assert desired(noted) == DesiredComponent(
        "",
        sets={"s": {"a": "2", "b": "1"}, "t": {"a": "9"}},
        active_set="s",
        active=("0",),
        rates={"0": 5.0},
        attached={"0": ("B",)},
        states={"s": {"e": "s"}},
        events={"e": "TimedLong"},
    )


def test_an_added_set_is_told_as_such_and_not_once_it_was_removed_or_taken_back() -> None:
    added = {"op": "set", "set_id": "s", "values": {"a": "1"}, "adds": "new"}
    more = {"op": "set", "set_id": "s", "values": {"b": "2"}}
    (action,) = requests_from(asked(added, more).by_component(["A"]))["A"]
    assert action == act.SetParameters("A", "s", {"a": "1", "b": "2"}, act.MISSING)
    gone = asked(added, {"op": "remove_set", "set_id": "s"})
    assert requests_from(gone.by_component(["A"]))["A"] == (act.RemoveSet("A", "s"),)
    assert desired(gone).sets == {}
    again = asked(added, {"op": "remove_set", "set_id": "s"}, {**added, "values": {"b": "3"}})
    assert desired(again).sets == {"s": {"b": "3"}}
    back = {"op": "set_back", "set_id": "s", "values": {"a": "1"}, "is_added": True}
    assert asked(added, back).by_component(["A"]) == {"A": []}


def test_what_was_taken_back_was_not_asked() -> None:
    noted = asked(
        {"op": "set", "set_id": "s", "values": {"a": "1", "b": "1"}},
        {"op": "set_back", "set_id": "s", "values": {"a": "1"}, "before": {}, "active_set": "s"},
    )
    assert desired(noted).sets == {"s": {"b": "1"}}


def test_what_ended_was_asked_nothing() -> None:
    noted = asked({"op": "attach", "context": "0", "participant": "B"})
    noted.forget("B")
    assert desired(noted) == DesiredComponent("")
    noted.note({"instance": "A", "op": "activate_set", "set_id": "s"})
    noted.forget("A")
    assert noted.by_component(["A"]) == {"A": []}


@pytest.mark.parametrize(
    "told",
    [
        [],
        {"A": {}},
        {"A": [1]},
        {"A": [{"op": "create"}]},
        {"A": [{"op": "set_rate", "rate": "x"}]},
    ],
)
def test_what_cannot_be_read_is_refused(told: object) -> None:
    with pytest.raises(Malformed):
        requests_from(told)


def test_who_tells_nothing_was_asked_nothing_known() -> None:
    assert requests_from(None) == {}
