"""What is wished for: noted from actions, kept as rows, read again."""

from __future__ import annotations

import pytest
from fake_shell import wire

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.deployment.facts import ComponentFacts
from rtkit.manager.core.desired import DesiredState
from rtkit.manager.core.desired_changes import note
from rtkit.rtc.enums import Transition
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import TypeProfile

ON, OFF = Transition.ACTIVATE, Transition.DEACTIVATE
NOTED: list[tuple[list[Action], dict[str, object]]] = [
    ([act.SetParameters("A", "s", {"p": "1"})], {"sets": {"s": {"p": "1"}}}),
    (
        [
            act.SetParameters("A", "s", {"p": "1", "q": "2"}),
            act.SetParameters("A", "s", {"p": "3"}),
        ],
        {"sets": {"s": {"p": "3", "q": "2"}}},
    ),
    (
        [act.SetParameters("A", "s", {"p": "1"}, act.NEW), act.RemoveSet("A", "s")],
        {"sets": {}},
    ),
    ([act.ActivateSet("A", "s")], {"active_set": "s"}),
    ([act.ChangeState("A", "0", ON), act.ChangeState("A", "1", ON)], {"active": ("0", "1")}),
    ([act.ChangeState("A", "0", ON), act.ChangeState("A", "0", OFF)], {"active": ()}),
    ([act.ChangeState("A", "0", ON), act.ChangeState("A", "0", Transition.RESET)], {"active": ()}),
    ([act.SetRate("A", "0", 5.0)], {"rates": {"0": 5.0}}),
    ([act.Attach("A", "0", "B"), act.Attach("A", "0", "B")], {"attached": {"0": ("B",)}}),
    ([act.Attach("A", "0", "B"), act.Detach("A", "0", "B")], {"attached": {"0": ()}}),
    ([act.SetStructure("A", {"x": {"e": "y"}})], {"states": {"x": {"e": "y"}}}),
    ([act.SetEventProfiles("A", {"e": "TimedLong"})], {"events": {"e": "TimedLong"}}),
]


def two() -> DesiredState:
    kept = DesiredState()
    for instance in "AB":
        kept.made(instance, f"Thing?instance_name={instance}", (), None)
    return kept


def read(kept: DesiredState) -> DesiredState:
    other = DesiredState()
    assert other.read(kept.changes()) == []
    return other


@pytest.mark.parametrize(("actions", "wished"), NOTED)
def test_actions_say_what_is_wished(actions: list[Action], wished: dict[str, object]) -> None:
    kept = two()
    for action in actions:
        note(kept, action)
    found = kept.components["A"]
    assert {name: getattr(found, name) for name in wished} == wished
    assert read(kept).components == kept.components


def test_all_kinds_are_read_again_in_their_order() -> None:
    kept = two()
    pattern = ComponentPattern(TypeProfile("X"), sets={"s": {"p": "1"}})
    kept.made("C", "stand-in?instance_name=C", ("localhost/C.rtc",), pattern)
    for action in (act.Load("m", "i"), act.Connect(wire("w")), act.Connect(wire("v", "B.out"))):
        note(kept, action)
    kept.put("setting", "logger.log_level", "DEBUG")
    kept.put("begun", "manager.components.precreate: A", "done")
    kept.lost(ComponentFacts("B", TypeProfile("Thing"), "s", zombie="signal 9"))
    other = read(kept)
    for table in ("components", "wires", "modules", "settings", "begun", "zombies"):
        assert getattr(other, table) == getattr(kept, table)
        assert list(getattr(other, table)) == list(getattr(kept, table))
    assert not other.has_changed


def test_only_what_changed_is_kept() -> None:
    kept = two()
    assert [row[:2] for row in kept.changes()] == [("component", "A"), ("component", "B")]
    note(kept, act.ActivateSet("A", ""))  # as it was
    note(kept, act.ActivateSet("B", "s"))
    note(kept, act.ActivateSet("Nobody", "s"))
    rows = kept.changes()
    assert [row[:2] for row in rows] == [("component", "B")]
    kept.not_kept(rows)
    assert kept.changes() == rows


def test_what_goes_takes_along_what_hangs_on_it() -> None:
    kept = two()
    note(kept, act.Connect(wire("w")))
    note(kept, act.Attach("A", "0", "B"))
    kept.changes()
    kept.forget("B")
    assert kept.changes() == (
        ("component", "B", None),
        ("wire", "w", None),
        ("component", "A", '{"create":"Thing?instance_name=A","attached":{"0":[]}}'),
    )


def test_made_by_hand_it_begins_anew_and_made_again_it_does_not() -> None:
    kept = two()
    note(kept, act.Connect(wire("w")))
    note(kept, act.ChangeState("A", "0", ON))
    before = dict(kept.components)
    kept.revived.add("A")
    kept.made("A", "Thing?instance_name=A", (), None)
    assert (kept.components, list(kept.wires)) == (before, ["w"])
    kept.revived.clear()
    kept.made("A", "Thing?instance_name=A", (), None)
    assert (kept.components["A"].active, kept.wires) == ((), {})


def test_rows_that_cannot_be_read_are_told_and_the_others_are_read() -> None:
    kept = DesiredState()
    rows = [
        ("component", "A", '{"create": 7}'),
        ("component", "B", "{"),
        ("wire", "w", "[]"),
        ("module", "m", "{}"),
        ("what", "x", "1"),
        ("component", "C", '{"create":"Thing"}'),
    ]
    assert [line.partition(":")[0] for line in kept.read(rows)] == [
        "component A",
        "component B",
        "wire w",
        "module m",
        "what x",
    ]
    assert list(kept.components) == ["C"]


def test_another_run_of_the_machine_is_noticed() -> None:
    kept = two()
    assert kept.begin_life("one")
    other = read(kept)
    assert other.begin_life("one")
    assert not other.begin_life("two")
    assert other.changes() == (("boot", "id", '"two"'),)
