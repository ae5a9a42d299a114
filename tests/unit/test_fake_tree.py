import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.deployment import actions as act
from rtkit.errors import NotFound
from rtkit.fast_dataclass import replace
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import TypeProfile


def test_the_real_client_sees_the_world():
    world = FakeManager([ComponentPattern(TypeProfile("Sink"))])
    tree = fake_tree(world)
    assert tree.perform(act.Create("Sink?manager_name=s")) == "Sink0"
    assert [row.instance for row in tree.listing().rows] == ["Sink0"]
    assert replace(tree.snapshot(), properties={}) == replace(world.snapshot(), properties={})


def test_errors_travel():
    tree = fake_tree(FakeManager())
    with pytest.raises(NotFound, match="component type Sink is not known"):
        tree.perform(act.Create("Sink"))
    with pytest.raises(NotFound):
        tree.get("nothing")


def test_an_ordered_batch_ends_at_its_first_failure():
    world = FakeManager([ComponentPattern(TypeProfile("Sink"))])
    actions = [act.Create("Sink"), act.Create("Nobody"), act.Create("Sink")]
    assert [r.ok for r in fake_tree(world).apply(actions)] == [True, False]
    assert [r.ok for r in fake_tree(world).apply(actions, is_ordered=False)] == [True, False, True]
