"""One follower of a manager, over a simulated world."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from queue import Queue
from threading import Event

import pytest
import statekit
from fake_manager import FakeManager

from rtkit.deployment.actions import Action, Result
from rtkit.deployment.delta import TREE
from rtkit.deployment.facts import Followed, Snapshot
from rtkit.deployment.plan_lock import LockHolder
from rtkit.deployment.states.states import States
from rtkit.deployment.states.states_text import spec_to_text
from rtkit.errors import Refused
from rtkit.manager.following.worker import Ended, FollowingWorker

WAIT_S = 10.0
OTHER = LockHolder("1", "rtapply robot.xml", "me", "box", 1)


class Place:
    """A world as the site of one follower."""

    def __init__(self, world: FakeManager) -> None:
        self.world = world
        self.is_over = False
        self.ended = Event()
        self.is_locked = False
        self.others = Event()
        self.others.set()
        self.locks = 0

    def end(self) -> None:
        self.is_over = True
        self.ended.set()

    def snapshot(self) -> Snapshot:
        if self.is_over:
            raise Ended
        return self.world.snapshot()

    remains = snapshot

    def apply(self, actions: Sequence[Action], *, is_ordered: bool = True) -> tuple[Result, ...]:
        if self.is_over:
            raise Ended
        assert self.is_locked
        return tuple(self.world.batch(actions, is_ordered))

    def start_manager(self, manager: str) -> None:
        raise Refused(manager)

    def end_started(self) -> list[str]:
        return []

    def holder(self) -> LockHolder | None:
        return None if self.others.is_set() else OTHER

    def pause(self, duration_s: float = 0.2) -> None:
        if self.ended.wait(min(duration_s, 0.01)):
            raise Ended

    def take_lock(self, waits: Callable[[str], object]) -> None:
        if self.is_over:
            raise Ended
        self.is_locked = True
        self.locks += 1

    def give_lock(self) -> None:
        self.is_locked = False


class Manager:
    """Plays a manager that follows one robot."""

    def __init__(self, states: States | None = None) -> None:
        self.states = states or statekit.robot()
        self.world = statekit.make_world()
        self.lines: Queue[Sequence[str]] = Queue()
        self.said: Queue[Followed] = Queue()
        self.worker: FollowingWorker
        self.place: Place

    def follow(self, told: Followed | None = None) -> None:
        self.place = Place(self.world)
        self.worker = FollowingWorker(
            spec_to_text(self.states, ["", ""]),
            told or Followed(statekit.SYSTEM),
            self.place,
            self.said.put,
            self.lines.put,
        )
        self.world.changed = self.worker.changed
        self.worker.start()

    def next(self) -> Followed:
        return self.said.get(timeout=WAIT_S)

    def came(self) -> str:
        """Return the next transition that was made."""
        while True:
            told = self.next()
            if not told.is_led and not told.waits:
                return str(told)

    def end(self) -> None:
        self.worker.end()
        self.worker.join(WAIT_S)
        assert not self.worker.is_alive()
        lines = ()
        while not self.lines.empty():
            lines = tuple(self.lines.get())
        assert lines == ()


@pytest.fixture
def manager() -> Manager:
    return Manager()


def test_it_leads_a_system_to_its_first_state_and_on_by_events(manager: Manager) -> None:
    manager.follow()
    assert manager.lines.get(timeout=WAIT_S) == (TREE,)
    begun = manager.next()
    assert (str(begun), begun.count, begun.is_led) == ("standby (at first)", 0, True)
    assert manager.came() == "standby (at first)"
    manager.end()
    # The next one goes on from there, without a transition.
    manager.follow(manager.worker.reached)
    assert manager.states.goal("explore") is not None
    _lead(manager, "explore")
    assert manager.came() == "standby -by others-> explore"
    manager.world.kill("Motor")
    assert manager.came() == "explore -motor_lost-> degraded"
    assert manager.worker.reached.count == 3
    assert manager.place.locks == 1
    assert not manager.place.is_locked
    manager.end()


def test_what_happened_while_nobody_followed_is_seen(manager: Manager) -> None:
    _lead(manager, "explore")
    manager.world.kill("Motor")
    manager.follow(Followed(statekit.SYSTEM, "explore", "standby", "start", 2))
    assert manager.came() == "explore -motor_lost-> degraded"
    manager.end()


def test_a_transition_that_was_broken_off_is_made(manager: Manager) -> None:
    _lead(manager, "standby")
    manager.follow(Followed(statekit.SYSTEM, "explore", "standby", "ready", 2, is_led=True))
    assert manager.came() == "standby -ready-> explore"
    assert manager.states.now(manager.world.snapshot()) == "explore"
    manager.end()


def test_it_waits_for_who_carries_a_plan_out_and_ends_while_it_does(manager: Manager) -> None:
    _lead(manager, "explore")
    manager.follow(Followed(statekit.SYSTEM, "explore", count=1))
    manager.place.others.clear()
    manager.world.kill("Motor")
    told = manager.next()
    assert (told.state, told.waits, told.is_led) == ("explore", str(OTHER), False)
    manager.place.others.set()
    assert manager.came() == "explore -motor_lost-> degraded"
    assert manager.worker.reached.waits == ""
    manager.end()
    _lead(manager, "explore")
    manager.follow(Followed(statekit.SYSTEM, "explore", count=1))
    manager.place.others.clear()
    manager.world.kill("Motor")
    assert manager.next().waits
    performed = len(manager.world.performed)
    manager.end()
    assert len(manager.world.performed) == performed


def test_what_is_so_while_somebody_carries_a_plan_out_is_no_state(manager: Manager) -> None:
    _lead(manager, "degraded")
    manager.follow(Followed(statekit.SYSTEM, "degraded", count=1))
    manager.place.others.clear()
    _lead(manager, "standby")
    _lead(manager, "explore")
    manager.place.others.set()
    manager.worker.changed()
    assert manager.came() == "degraded -by others-> explore"
    # An event that has gone by then leads nowhere.
    manager.place.others.clear()
    manager.world.kill("Motor")
    assert manager.next().waits
    _lead(manager, "explore")
    manager.place.others.set()
    assert manager.next().waits == ""
    assert manager.said.empty()
    manager.end()


def test_a_transition_that_fails_ends_it_or_leads_on() -> None:
    manager = Manager(statekit.robot(**{"state.degraded": "Motor0=Absent; Eye0.gain=9"}))
    _lead(manager, "explore")
    manager.world.fault = statekit.gain_refused
    manager.follow(Followed(statekit.SYSTEM, "explore", count=1))
    manager.world.kill("Motor")
    while not (told := manager.next()).is_over:
        pass
    assert told.why.startswith("explore -motor_lost-> degraded: ")
    assert (told.kind, told.state, told.is_led) == ("refused", "degraded", False)
    manager.worker.join(WAIT_S)
    assert not manager.worker.is_alive()
    assert not manager.place.is_locked

    manager = Manager(statekit.robot(**statekit.FAILING))
    _lead(manager, "explore")
    manager.world.fault = statekit.gain_refused
    manager.follow(Followed(statekit.SYSTEM, "explore", count=1))
    manager.world.kill("Motor")
    while (told := manager.next()).event != "failed" or told.is_led:
        pass
    assert str(told) == "degraded -failed-> standby"
    assert told.why.startswith("explore -motor_lost-> degraded: ")
    assert not told.is_over
    manager.end()


def test_what_cannot_be_read_is_followed_no_more(manager: Manager) -> None:
    manager.place = Place(manager.world)
    worker = FollowingWorker(
        "{}", Followed("S"), manager.place, manager.said.put, manager.lines.put
    )
    worker.start()
    told = manager.next()
    assert told.is_over
    assert "not what a system is followed by" in told.why


def _lead(manager: Manager, state: str) -> None:
    """Lead the system to a state as another command would."""
    from fake_tree import fake_tree

    from rtkit.deployment.applying import Applier

    changed = manager.world.changed
    tree, goal = fake_tree(manager.world), manager.states.goal(state)
    before = tree.snapshot()
    Applier(tree, goal, lambda _: None, lambda _: None).run(goal.plan(before), before)
    manager.world.changed = changed
    changed()
