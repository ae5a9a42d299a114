"""Behaviours: their target and what remains, a new target in place of the old, stopping."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Generator, Iterator
from typing import Any

import pytest

import rtkit
from rtkit import Marker
from rtkit.property.functional import FunctionalProperty
from rtkit.property.objects import Exported
from rtkit.property.service import Service
from rtkit.property.user_code import Finished, UserCode, Work
from tests.unit.property.test_objects import refused

HERE = "<marker><location>(1.0 0.0)</location></marker>"
THERE = "<marker><location>(2.0 0.0)</location></marker>"


@dataclasses.dataclass
class Rest:
    remaining: float
    points: int


class Behaviors:
    def __init__(self) -> None:
        self._begun: list[object] = []

    @rtkit.behavior
    def moveto(self, target: Marker | list[Marker]) -> Iterator[object]:
        self._begun.append(target)
        for left in (3, 2, 1):
            yield {"remaining": left, "points": 1}

    @rtkit.behavior
    def turn(self, angle: float) -> Generator[object, None, str]:
        yield Rest(angle / 2, 1)
        yield 0.1
        return "there"

    def beep(self) -> None:
        pass


class Robot:
    def __init__(self) -> None:
        self.behaviors = Behaviors()


class ByHand(UserCode):
    """Runs actions up to where it is told to."""

    def __init__(self) -> None:
        self.waiting: list[tuple[Work, Finished]] = []
        self.at_step: Callable[[], object] = lambda: None

    def start(self, work: Work, finished: Finished) -> None:
        self.waiting.append((work, finished))

    def post(self, work: Work) -> None:
        work()
        self.at_step()

    def run(self, at_step: Callable[[], object] = lambda: None) -> None:
        """Do the work that waits; `at_step` is called once, after its first step."""

        def once() -> None:
            self.at_step = lambda: None
            at_step()

        self.at_step = once
        work, finished = self.waiting.pop(0)
        try:
            finished(work(), None)
        except RuntimeError as error:
            finished(None, error)


@pytest.fixture
def robot() -> tuple[Behaviors, ByHand, Service]:
    thing, service, hand = Robot(), Service("r"), ByHand()
    service.values.user_code = hand
    Exported(service, thing)
    return thing.behaviors, hand, service


Told = tuple[Behaviors, ByHand, Service]
MOVE = "behaviors.moveto"


def shown(state: str, target: str, rest: str = "<remaining/>") -> str:
    if target.count("<marker>") == 1:
        target = target.removeprefix("<marker>").removesuffix("</marker>")
    inner = f"<target>{target}</target>" if target else "<target/>"
    return f'<behavior state="{state}">{inner}{rest}</behavior>'


def test_a_behaviour_tells_target_and_rest(robot: Told) -> None:
    behaviors, hand, service = robot
    assert service.get(MOVE) == shown("idle", "")
    service.set(MOVE, HERE)
    assert service.get(MOVE) == shown("running", HERE)
    seen: list[Any] = []
    hand.run(lambda: seen.append(service.get(MOVE)))
    assert seen == [shown("running", HERE, "<remaining>3</remaining><points>1</points>")]
    assert service.get(f"{MOVE}.state") == "done"
    assert service.get(f"{MOVE}.remaining") == "1"
    assert service.get(f"{MOVE}.target.location.0") == "1.0"
    assert behaviors._begun == [Marker((1, 0))]
    service.set("behaviors.turn", "1.0")
    hand.run(lambda: seen.append(service.get("behaviors.turn")))
    rest = "<remaining>0.5</remaining><points>1</points>"
    assert seen[1] == shown("running", "1.0", rest)
    result = "<remaining>0.1</remaining><result>&quot;there&quot;</result>"
    assert service.get("behaviors.turn") == shown("done", "1.0", result.replace("&quot;", '"'))


def test_a_new_target_replaces_the_old(robot: Told) -> None:
    behaviors, hand, service = robot
    events: list[Any] = []
    node = service.registry.nodes[MOVE]
    keep = service.values.keep

    def keeping(kept: Any, value: Any, quality: str = "good") -> None:
        keep(kept, value, quality)
        if kept is node:
            events.append(service.get(f"{MOVE}.state"))

    service.values.keep = keeping  # type: ignore[method-assign]
    service.set(MOVE, HERE)

    def change_our_mind() -> None:
        service.set(MOVE, THERE)
        assert service.get(MOVE) == shown("running", THERE)
        service.set(MOVE, f"({HERE} {THERE})")

    hand.run(change_our_mind)
    assert service.get(MOVE) == shown("running", HERE + THERE)
    assert behaviors._begun == [Marker((1, 0))]
    assert len(hand.waiting) == 1
    hand.run()
    assert behaviors._begun[1:] == [[Marker((1, 0)), Marker((2, 0))]]
    assert service.get(f"{MOVE}.state") == "done"
    assert events[:2] == ["running", "running"]
    assert events.count("stopped") == 2
    assert events[-1] == "done"


def test_behaviours_are_stopped_alone_and_together(robot: Told) -> None:
    behaviors, hand, service = robot
    service.set(MOVE, HERE)
    hand.run(lambda: service.set(f"{MOVE}.stop", "true"))
    assert service.get(f"{MOVE}.state") == "stopped"
    service.set(MOVE, HERE)
    service.set("behaviors.turn", "1")
    hand.run(lambda: service.set("behaviors.stop", "true"))
    assert service.get(f"{MOVE}.state") == "stopped"
    assert refused(service, "behaviors.stop") == "write-only"
    hand.run()
    assert service.get("behaviors.turn.state") == "stopped"
    assert service.get("behaviors") == "(moveto turn beep)"
    # One that waits for the end of the one it replaces never begins when it is stopped.
    service.set(MOVE, HERE)

    def then_stop() -> None:
        service.set(MOVE, THERE)
        service.set("stop", "true")

    begun = len(behaviors._begun)
    hand.run(then_stop)
    assert service.get(f"{MOVE}.state") == "stopped"
    assert hand.waiting == []
    assert len(behaviors._begun) == begun + 1


def test_what_no_target_can_be_is_refused_at_once(robot: Told) -> None:
    behaviors, hand, service = robot
    for wrong in ("there", "(1 2)", "<other/>", f"({HERE} 3)"):
        assert refused(service, MOVE, wrong) == "bad-value"
    assert service.get(f"{MOVE}.state") == "idle"
    assert refused(service, "behaviors.beep.stop.x", "true") != ""
    assert refused(service, "nothing.stop", "true") == "unknown"
    assert hand.waiting == []
    assert behaviors._begun == []


def test_an_action_that_is_no_behaviour_stays_busy() -> None:
    service = Service()
    service.add("go", function=FunctionalProperty(lambda: None, run=lambda work, end: None))
    service.set("go", "")
    assert refused(service, "go", "") == "busy"
    assert refused(service, "stop", "true") == "conflict"
