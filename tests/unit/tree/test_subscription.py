"""An ear at a manager: what it hears, what it misses, what it knows in the end."""

from __future__ import annotations

import json
from typing import Any

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree
from worlds import things

from rtkit.deployment import actions as act
from rtkit.deployment.delta import Delta
from rtkit.errors import Unreachable
from rtkit.rtc.enums import Transition
from rtkit.rtc.serde import encode
from rtkit.tree import subscription
from rtkit.tree.client import Tree
from rtkit.tree.subscription import ManagerSubscription, SubscriptionEnded, TreeChange


@pytest.fixture
def world() -> FakeManager:
    return things("A")


def events(heard: list[Any]) -> list[str]:
    return [each.event for change in heard for each in change.user_events]


def test_it_hears_what_happens_and_knows_what_is(world: FakeManager) -> None:
    with ManagerSubscription(fake_tree(world)) as subscription:
        assert [each.instance for each in subscription.facts.components] == ["A"]
        assert subscription.take() == []
        world.perform(act.ChangeState("A", "0", Transition.ACTIVATE))
        assert events(subscription.wait(10.0)) == ["ACTIVE"]
        assert subscription.facts.components[0].state == "Active"
        assert subscription.wait(0.0) == []


def test_who_is_too_slow_learns_what_it_came_to(
    world: FakeManager, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rtkit.tree.subscription.QUEUE", 4)
    with ManagerSubscription(fake_tree(world)) as subscription:
        for transition in [Transition.ACTIVATE, Transition.DEACTIVATE] * 10:
            world.perform(act.ChangeState("A", "0", transition))
        world.perform(act.ChangeState("A", "0", Transition.ACTIVATE))
        heard = subscription.wait(10.0)
        assert isinstance(heard[0], TreeChange)
        assert heard[0].lost > 0
        assert events(heard) == ["ACTIVE"]
        world.perform(act.ChangeState("A", "0", Transition.DEACTIVATE))
        assert events(subscription.wait(10.0)) == ["INACTIVE"]


def test_the_last_news_end_it(world: FakeManager) -> None:
    tree = fake_tree(world)
    with ManagerSubscription(tree) as subscription:
        tell = subscription._take_in("tree")
        number = tree.full_snapshot().number
        tell(json.dumps(encode(Delta("fake", number + 1, is_last=True))))
        ended = SubscriptionEnded("manager 'manager' ends", is_orderly=True)
        assert subscription.wait(10.0) == [ended]
        assert subscription.wait(10.0) == []


def test_what_is_told_after_its_end_is_not_heard(world: FakeManager) -> None:
    with ManagerSubscription(fake_tree(world)) as subscription:
        tell = subscription._take_in("tree")
    tell("late")


def test_news_that_do_not_arrive(world: FakeManager, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subscription, "_FIRST_DELTA_S", 0.0)
    monkeypatch.setattr(Tree, "listen", lambda *_: lambda: None)
    with pytest.raises(Unreachable, match="does not arrive"):
        ManagerSubscription(fake_tree(world))
