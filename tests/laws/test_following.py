"""A manager that dies at any moment of a transition: the next one makes it, once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import statekit
from fake_manager import FakeManager
from fake_tree import fake_tree
from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.deployment.actions import Action, Result
from rtkit.deployment.applying import Applier
from rtkit.deployment.facts import Followed, Snapshot
from rtkit.deployment.states.states_text import spec_to_text
from rtkit.errors import Refused
from rtkit.manager.following.worker import Ended, FollowingWorker

STATES = statekit.robot()
TEXT = spec_to_text(STATES, ["", ""])


class Dying:
    """A site that ends before or after one of its calls, or when nothing is left to be done."""

    is_over = False

    def __init__(self, world: FakeManager, calls: int | None) -> None:
        self.world = world
        self.left = calls
        self.changed: Callable[[], object] = lambda: None

    def _count(self) -> None:
        if self.left is not None:
            self.left -= 1
            if self.left < 0:
                raise Ended

    def end(self) -> None:
        raise AssertionError

    def snapshot(self) -> Snapshot:
        self._count()
        self.changed()
        return self.world.snapshot()

    remains = snapshot

    def apply(self, actions: Sequence[Action], *, is_ordered: bool = True) -> tuple[Result, ...]:
        self._count()
        results = tuple(self.world.batch(actions, is_ordered))
        self._count()
        return results

    def start_manager(self, manager: str) -> None:
        raise Refused(manager)

    def end_started(self) -> list[str]:
        return []

    def holder(self) -> None:
        self._count()

    def pause(self, duration_s: float = 0.0) -> None:
        raise Ended  # nothing is left to be done

    def take_lock(self, waits: Callable[[str], object]) -> None:
        self._count()

    def give_lock(self) -> None:
        pass


def live(world: FakeManager, kept: list[Followed], calls: int | None) -> None:
    """Live one life of a manager, from what is kept to the given call."""
    site = Dying(world, calls)

    def say(told: Followed) -> None:
        site._count()
        kept.append(told)
        site._count()

    worker = FollowingWorker(TEXT, kept[-1], site, say, lambda _lines: None)
    site.changed = worker.changed
    worker.run()


def lead(world: FakeManager, state: str) -> None:
    tree, goal = fake_tree(world), STATES.goal(state)
    before = tree.snapshot()
    Applier(tree, goal, lambda _: None, lambda _: None).run(goal.plan(before), before)


@given(st.lists(st.integers(0, 25), max_size=5), st.booleans())
@settings(max_examples=60, deadline=None)
def test_whenever_it_dies_the_next_one_goes_on_and_makes_each_transition_once(
    deaths: list[int], is_new: bool
) -> None:
    world = statekit.make_world()
    kept = [Followed(statekit.SYSTEM)]
    if not is_new:
        lead(world, "explore")
        kept = [Followed(statekit.SYSTEM, "explore", "standby", "start", 1)]
        world.kill("Motor")
    for calls in deaths:
        live(world, kept, calls)
    live(world, kept, None)
    expected = "standby" if is_new else "degraded"
    assert STATES.now(world.snapshot()) == expected
    last = kept[-1]
    assert (last.state, last.is_led, last.is_over) == (expected, False, False)
    assert last.count == (1 if is_new else 2)
    if not is_new:
        assert str(last) == "explore -motor_lost-> degraded"
    performed = len(world.performed)
    live(world, kept, None)
    assert len(world.performed) == performed
    assert kept[-1] is last
