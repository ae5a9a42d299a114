"""What a system is followed by, as text and back."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
import statekit

from rtkit.deployment.facts import Followed
from rtkit.deployment.planning.step_costs import Costs
from rtkit.deployment.states.states import States
from rtkit.deployment.states.states_text import spec_from_text, spec_to_text
from rtkit.errors import Malformed
from rtkit.fast_dataclass import replace as changed
from rtkit.rtc.serde import decode, encode


def test_what_a_system_is_followed_by_travels() -> None:
    made = statekit.robot()
    first, *more = made.base.system.components
    first = changed(first, kept=frozenset({("default", "gain")}), guests=(("0", "Motor0"),))
    system = changed(made.base.system, components=(first, *more))
    base = replace(made.base, system=system, ranks={"Eye0": 1}, replaces=True, is_strict=True)
    base = replace(base, costs=Costs().over({"create Eye0": 7.0}, "user"))
    states = States(made.name, made.machine, base)
    found, rolls_back = spec_from_text(spec_to_text(states, ["a.xml", "1"], rolls_back=True))
    assert rolls_back
    assert (found.name, found.machine, found.base) == (states.name, states.machine, base)
    assert list(found.machine.table) == list(states.machine.table)
    assert all(found.goal(state) == states.goal(state) for state in states.machine.table)


@pytest.mark.parametrize(
    "change",
    [
        {"table": {}},
        {"table": {"a": {"go": "b"}}},
        {"wishes": {}},
        {"wanted": {"rubbish": 1}},
        {"costs": 1},
        {"conditions": {"e": [1, 2, 3, 4, 5]}},
        {"ranks": []},
    ],
)
def test_rubbish_is_refused(change: dict[str, object]) -> None:
    plain = json.loads(spec_to_text(statekit.robot(), ["", ""]))
    with pytest.raises(Malformed):
        spec_from_text(json.dumps({**plain, **change}))
    for text in ("", "[]", "1", "{}", "[" * 5000):
        with pytest.raises(Malformed):
            spec_from_text(text)


def test_what_became_of_it_is_told_in_words_and_travels() -> None:
    told = Followed("S", "b", "a", "go", 2, 1.0)
    assert str(told) == "a -go-> b"
    assert str(Followed("S", "a", "", "is so", 1)) == "a (is so)"
    assert str(Followed("S")) == "not looked at yet"
    assert decode(Followed, encode(told)) == told
