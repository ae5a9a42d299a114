"""An ear at a manager: what it hears, what it misses, what it knows in the end."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rtkit.deployment import actions as act
from rtkit.deployment.news import News
from rtkit.deployment.world import World
from rtkit.errors import Unreachable
from rtkit.rtc.enums import Transition
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.plain import encode
from rtkit.rtc.profiles import TypeProfile
from rtkit.tree import listening
from rtkit.tree.client import Tree
from rtkit.tree.fake import fake_tree
from rtkit.tree.listening import Change, Ear, Ended


@pytest.fixture
def world() -> World:
    world = World([ComponentPattern(TypeProfile("Thing"))])
    world.perform(act.Create("Thing?instance_name=A"))
    return world


def events(heard: list[Any]) -> list[str]:
    return [each.event for change in heard for each in change.happenings]


def test_it_hears_what_happens_and_knows_what_is(world: World) -> None:
    with Ear(fake_tree(world)) as ear:
        assert [each.instance for each in ear.facts.components] == ["A"]
        assert ear.take() == []
        world.perform(act.ChangeState("A", "0", Transition.ACTIVATE))
        assert events(ear.wait(10.0)) == ["ACTIVE"]
        assert ear.facts.components[0].state == "Active"
        assert ear.wait(0.0) == []


def test_who_is_too_slow_learns_what_it_came_to(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(listening, "QUEUE", 4)
    with Ear(fake_tree(world)) as ear:
        for transition in [Transition.ACTIVATE, Transition.DEACTIVATE] * 10:
            world.perform(act.ChangeState("A", "0", transition))
        world.perform(act.ChangeState("A", "0", Transition.ACTIVATE))
        heard = ear.wait(10.0)
        assert isinstance(heard[0], Change)
        assert heard[0].lost > 0
        assert events(heard) == ["ACTIVE"]
        world.perform(act.ChangeState("A", "0", Transition.DEACTIVATE))
        assert events(ear.wait(10.0)) == ["INACTIVE"]


def test_the_last_news_end_it(world: World) -> None:
    tree = fake_tree(world)
    with Ear(tree) as ear:
        tell = ear._take_in("tree")
        number = tree.picture().number
        tell(json.dumps(encode(News("fake", number + 1, is_last=True))))
        assert ear.wait(10.0) == [Ended("manager 'manager' ends")]
        assert ear.wait(10.0) == []


def test_what_is_told_after_its_end_is_not_heard(world: World) -> None:
    with Ear(fake_tree(world)) as ear:
        tell = ear._take_in("tree")
    tell("late")


def test_news_that_do_not_arrive(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listening, "_HEAR_S", 0.0)
    monkeypatch.setattr(Tree, "listen", lambda *_: lambda: None)
    with pytest.raises(Unreachable, match="does not arrive"):
        Ear(fake_tree(world))
