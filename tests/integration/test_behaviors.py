"""Behaviours and values that return, of what is served: many clients at once, and time."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from typing import Annotated

import pytest

import rtkit

BOUND_S = 30.0


class Behaviors:
    def __init__(self) -> None:
        self._at_work: list[float] = []
        self._most = 0
        self._ended = 0

    @rtkit.behavior
    def turn(self, angle: float) -> Iterator[float]:
        with _working(self, angle):
            while angle < 1e6:
                yield angle
                time.sleep(0.0005)

    @rtkit.behavior
    async def wait(self, angle: float) -> AsyncIterator[float]:
        with _working(self, angle):
            while angle < 1e6:
                yield angle
                await asyncio.sleep(0.0005)

    @rtkit.behavior
    def fail(self, angle: float) -> Iterator[float]:
        yield angle
        raise RuntimeError("the gear is broken")


class _working:  # noqa: N801
    def __init__(self, behaviors: Behaviors, angle: float) -> None:
        self._of, self._angle = behaviors, angle

    def __enter__(self) -> None:
        self._of._at_work.append(self._angle)
        self._of._most = max(self._of._most, len(self._of._at_work))

    def __exit__(self, *error: object) -> None:
        self._of._at_work.remove(self._angle)
        self._of._ended += 1


class Robot:
    speed: Annotated[float, rtkit.Returns(after=0.2)] = 0.0

    def __init__(self) -> None:
        self.behaviors = Behaviors()


def until(holds: Callable[[], bool]) -> None:
    deadline = time.monotonic() + BOUND_S
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.005)


@pytest.mark.parametrize("name", ["turn", "wait"])
def test_of_many_targets_at_once_one_is_pursued(place: str, name: str) -> None:
    robot = Robot()
    target = f"robot.behaviors.{name}"
    with rtkit.serve(robot, "robot", is_on_zenoh=False), rtkit.Client(timeout_s=BOUND_S) as client:

        def drive(number: int) -> None:
            for step in range(25):
                client.set(target, float(100 * number + step))

        drivers = [threading.Thread(target=drive, args=(number,)) for number in range(4)]
        for each in drivers:
            each.start()
        for each in drivers:
            each.join()
        element = client.get(target)
        last = element.find("target").leaf
        assert element.attributes["state"] == "running"
        until(lambda: robot.behaviors._at_work == [last])
        assert robot.behaviors._most == 1
        client.set("robot.behaviors.stop", True)
        until(lambda: str(client.get(f"{target}.state")) == "stopped")
        assert robot.behaviors._at_work == []


def test_who_waits_for_a_behaviour_is_answered_when_it_is_replaced(place: str) -> None:
    with rtkit.serve(Robot(), "robot", is_on_zenoh=False), rtkit.Client(BOUND_S) as client:
        answers: list[object] = []

        def wait() -> None:
            answers.append(client.get("robot.behaviors.turn.state"))
            client.set("robot.behaviors.turn", 1.0, echo=1)
            answers.append("answered")

        waiting = threading.Thread(target=wait)
        waiting.start()
        until(lambda: str(client.get("robot.behaviors.turn.state")) == "running")
        client.set("robot.behaviors.turn", 2.0)
        waiting.join(BOUND_S)
        assert answers[1:] == ["answered"]
        client.set("robot.behaviors.turn", 1e6)
        until(lambda: str(client.get("robot.behaviors.turn.state")) == "done")
        client.set("robot.behaviors.fail", 1.0)
        until(lambda: str(client.get("robot.behaviors.fail.state")) == "failed")
        assert "broken" in str(client.get("robot.behaviors.fail"))
        client.set("robot.behaviors.fail", 2.0)


def test_a_value_returns_in_time_and_not_before(place: str) -> None:
    robot = Robot()
    with rtkit.serve(robot, "robot", is_on_zenoh=False), rtkit.Client(BOUND_S) as client:
        begun = time.monotonic()
        for _ in range(5):
            client.set("robot.speed", 1.0)
            time.sleep(0.05)
        until(lambda: robot.speed == 0.0)
        assert time.monotonic() - begun >= 0.4
