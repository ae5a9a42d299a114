"""Configuration sets by scripts: changed, added, copied, removed, as rtconf does."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager
from fake_tree import tree_of
from worlds import made

from rtkit.api.tree import Tree
from rtkit.deployment import actions as act
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import TypeProfile

A = "/localhost/A.rtc"


@pytest.fixture
def world() -> FakeManager:
    sets = {
        "default": {"gain": "1"},
        "fast": {"gain": "9"},
        "__constraints__": {"gain": "0<=x<=9"},
        "__type__": {"gain": "double"},
    }
    return made(
        FakeManager([ComponentPattern(TypeProfile("Std"), (), sets)]), "Std?instance_name=A"
    )


@pytest.fixture
def tree(world: FakeManager, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Tree]:
    monkeypatch.chdir(tmp_path)
    with tree_of(Tree, world) as tree:
        yield tree


def test_parameters_are_changed_all_or_none(tree: Tree, world: FakeManager) -> None:
    tree.configure(A, gain="2")
    assert world.components["A"].sets["default"] == {"gain": "2"}
    assert world.performed[-1] == act.ActivateSet("A", "default")
    tree.configure(A, "fast", gain="8")
    assert world.components["A"].sets["fast"] == {"gain": "8"}
    assert world.performed[-1] == act.SetParameters("A", "fast", {"gain": "8"})
    world.performed.clear()
    with pytest.raises(NotFound, match=r"No such configuration parameter: gian \(did you mean"):
        tree.configure(A, gain="3", gian="1")
    with pytest.raises(NotFound, match="No such configuration set: slow"):
        tree.configure(A, "slow", gain="1")
    with pytest.raises(Malformed, match=r"gain cannot be '10': it is to be 0<=x<=9"):
        tree.configure(A, gain=10)
    assert world.performed == []


def test_values_are_text_numbers_or_truth(tree: Tree, world: FakeManager) -> None:
    for value, text in ((0.5, "0.5"), (7, "7"), ("3", "3")):
        tree.configure(A, gain=value)
        assert world.components["A"].sets["default"]["gain"] == text
    nothing: Any = None
    with pytest.raises(TypeError, match=r"value of gain is text, not NoneType: None"):
        tree.configure(A, gain=nothing)
    with pytest.raises(TypeError, match="is text, not"):
        tree.configure(nothing)


def test_a_set_is_added_copied_activated_and_removed(tree: Tree, world: FakeManager) -> None:
    tree.add_set(A, "slow", gain=0.1)
    tree.copy_set(A, "fast", "faster")
    tree.copy_set(A, "fast", "fastest", gain=9)
    sets = tree.component(A).sets
    assert [sets[name] for name in ("slow", "faster", "fastest")] == [
        {"gain": "0.1"},
        {"gain": "9"},
        {"gain": "9"},
    ]
    tree.activate_set(A, "slow")
    assert tree.component(A).active_set == "slow"
    tree.remove_set(A, "faster")
    assert world.performed[-1] == act.RemoveSet("A", "faster")


def test_what_no_set_can_be_is_refused_before_anything_is_sent(
    tree: Tree, world: FakeManager
) -> None:
    with pytest.raises(Refused, match="configuration set fast exists already"):
        tree.add_set(A, "fast", gain=1)
    with pytest.raises(Malformed, match="gain cannot be 'x': it is no number"):
        tree.add_set(A, "slow", gain="x")
    with pytest.raises(NotFound, match="No such configuration parameter: gian"):
        tree.copy_set(A, "fast", "slow", gian=1)
    for call in (
        tree.remove_set,
        tree.activate_set,
        lambda path, name: tree.copy_set(path, name, "x"),
    ):
        with pytest.raises(
            NotFound, match=r"No such configuration set: fats \(did you mean fast\?\)"
        ):
            call(A, "fats")
        with pytest.raises(NotFound, match=r"No such object: /localhost/B\.rtc"):
            call("/localhost/B.rtc", "fast")
    assert world.performed == []
