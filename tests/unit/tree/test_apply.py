"""Carrying out plans on the fake world, failures and interruptions included."""

import threading

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree
from worlds import made

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.layered_plan import Check, Layer, LayeredPlan, PlannedAction
from rtkit.deployment.runner import PlanRunner, roll_back
from rtkit.deployment.site import UNFINISHED
from rtkit.errors import Refused, Unreachable
from rtkit.rtc.enums import ReturnCode
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import TypeProfile
from rtkit.tree import grace
from rtkit.tree.grace import uninterrupted

SETS = {"default": {"a": "1", "b": "1"}}
NO = Result(ReturnCode.ERROR, "refused", "no")


@pytest.fixture
def world():
    return made(FakeManager([ComponentPattern(TypeProfile("Sink"), sets=SETS)]), "Sink")


@pytest.fixture
def talk():
    return []


@pytest.fixture
def runner(world, talk):
    return PlanRunner(fake_tree(world), talk.append)


def step(action, required=False, **more):
    return PlannedAction("text", action, required, **more)


def plan(*steps, **how):
    return LayeredPlan(layers=(Layer("do", steps, **how),))


def test_checks_are_told_or_refused(runner, talk):
    runner.check([Check("a"), Check("b", "b is odd", is_required=False)])
    assert talk == ["Action failed: b is odd"]
    talk.clear()
    with pytest.raises(Refused, match=r"^Required action failed: d is worse$"):
        runner.check([Check("c", "c is bad"), Check("d", "d is worse")])
    assert talk == ["Required action failed: c is bad"]


def test_parameters_of_a_set_are_written_at_once(runner, world):
    steps = [step(act.SetParameters("Sink0", "default", {name: "2"})) for name in "ab"]
    runner.run(plan(*steps))
    assert world.performed == [act.SetParameters("Sink0", "default", {"a": "2", "b": "2"})]
    assert runner.done == steps


def test_a_required_failure_stops_before_the_next_layer(runner, world, talk):
    two = LayeredPlan(
        layers=(
            Layer("1", (step(act.Create("No"), True), step(act.Create("Nor"), True))),
            Layer("2", (step(act.Create("Sink"), True),)),
        )
    )
    with pytest.raises(Refused, match=r"^Required action failed: component type Nor is not known$"):
        runner.run(two)
    assert talk == ["Required action failed: component type No is not known"]
    assert len(world.components) == 1


def test_optional_failures_are_told_once_and_the_rest_goes_on(runner, world, talk):
    blocked = [step(None, blocked="it is not there") for _ in range(2)]
    runner.run(plan(*blocked, step(act.Create("No")), step(act.Create("Sink"))))
    assert talk == [
        "Action failed: it is not there",
        "Action failed: component type No is not known",
    ]
    assert len(world.components) == 2


def test_what_is_known_to_fail_and_required_is_not_begun(runner, world):
    with pytest.raises(Refused, match=r"^Required action failed: no port$"):
        runner.run(plan(step(act.Create("Sink")), step(None, True, blocked="no port")))
    assert world.performed == []


def test_in_order_one_after_the_other(runner, world, talk):
    steps = [
        PlannedAction("{1} first", act.Create("Sink"), True),
        PlannedAction("{2} second", act.Create("No")),
        PlannedAction("{3} third", None, blocked="gone"),
        PlannedAction("{4} fourth", act.Create("Sink"), True),
    ]
    runner.run(plan(*steps, is_ordered=True))
    assert talk == [
        "Action failed: component type No is not known",
        "Action failed: gone",
    ]
    assert [s.text for s in runner.done] == ["{1} first", "{4} fourth"]


def test_in_order_a_required_failure_ends_the_plan(runner, world):
    steps = [step(act.Create("No"), True), step(act.Create("Sink"))]
    with pytest.raises(Refused, match="component type No is not known"):
        runner.run(plan(*steps, is_ordered=True))
    assert len(world.components) == 1


def test_regret_takes_back_and_tells(runner, world):
    before = world.snapshot()
    runner.run(plan(step(act.Create("Sink?instance_name=New"))))
    assert roll_back(runner, before, Refused()) == "removed again: New"
    assert world.snapshot() == before


def test_regret_says_nothing_when_nothing_was_tried(runner, world):
    assert roll_back(runner, world.snapshot(), Refused()) == ""


def test_regret_says_what_remains(runner, world):
    before = world.snapshot()
    runner.run(
        plan(step(act.Create("Sink?instance_name=A")), step(act.Create("No?instance_name=B")))
    )
    world.fault = lambda action: NO if isinstance(action, act.Delete) else None
    assert roll_back(runner, before, Refused()) == "remains: A (no)"


def test_regret_tells_what_was_removed_when_the_manager_falls_silent(runner, world):
    before = world.snapshot()
    runner.run(plan(*(step(act.Create(f"Sink?instance_name={name}")) for name in "ABC")))

    def fault(action):
        if action == act.Delete("B"):
            raise Unreachable("it fell silent")

    world.fault = fault
    told = roll_back(runner, before, Refused())
    assert told == "removed again: A; remains: B (manager on box: it fell silent), C"


def test_regret_without_a_manager_says_so(world, talk):
    tree = fake_tree(world)
    runner = PlanRunner(tree, talk.append)
    before = world.snapshot()
    runner.run(plan(step(act.Create("Sink?instance_name=A"))))
    tree.close()
    assert "could not be removed (manager on box" in roll_back(runner, before, Refused())


def test_a_call_that_fails_raises_in_the_caller():
    def fail():
        raise Unreachable("gone")

    with pytest.raises(Unreachable, match="gone"):
        uninterrupted(fail)


class _Interrupted(threading.Event):
    """An event whose first wait is broken off by Ctrl-C."""

    def __init__(self):
        super().__init__()
        self.waits = 0

    def wait(self, timeout=None):
        self.waits += 1
        if self.waits == 1:
            raise KeyboardInterrupt
        return super().wait(timeout)


def test_an_interruption_waits_for_the_call_under_way(monkeypatch):
    monkeypatch.setattr(grace, "Event", _Interrupted)
    finished = []
    with pytest.raises(KeyboardInterrupt) as caught:
        uninterrupted(lambda: finished.append(1))
    assert finished == [1]
    assert caught.value.args == ()


def test_an_interruption_does_not_wait_for_ever(monkeypatch, runner, world):
    monkeypatch.setattr(grace, "Event", _Interrupted)
    monkeypatch.setattr(grace, "GRACE_S", 0.01)
    release = threading.Lock()
    release.acquire()
    with pytest.raises(KeyboardInterrupt) as caught:
        uninterrupted(release.acquire)
    release.release()
    assert caught.value.args == (UNFINISHED,)
    monkeypatch.undo()
    before = world.snapshot()
    runner.run(plan(step(act.Create("Sink?instance_name=New"))))
    told = roll_back(runner, before, caught.value)
    assert told == (
        "removed again: New; the manager may still be busy with what it was last asked for"
    )


def test_notes_on_what_was_done_are_told(world, talk):
    tree = fake_tree(world)
    tree.apply = lambda actions, **_how: tuple(Result(note="it is odd") for _ in actions)
    PlanRunner(tree, talk.append).run(plan(step(act.Create("Sink?instance_name=A"))))
    assert talk == ["note: it is odd"]


def test_what_is_made_strictly_says_so_to_the_manager(world, talk):
    sent = []
    tree = fake_tree(world)
    tree.apply = lambda actions, **_how: (sent.extend(actions), (Result(),) * len(actions))[1]
    made = [act.Load("a.py"), act.Create("Sink"), act.Delete("Sink0")]
    PlanRunner(tree, talk.append, is_strict=True).run(plan(*map(step, made)))
    assert sent == [act.Load("a.py", is_strict=True), act.Create("Sink", is_strict=True), made[2]]
