"""Values that return by themselves when nobody sets them any more."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

import pytest

from rtkit import PropertyError, Returns, Unit
from rtkit.property.messages import Answer
from rtkit.property.objects import Exported
from rtkit.property.requests import PropertyRequest
from rtkit.property.service import Service
from rtkit.property.user_code import UserCode
from tests.unit.property.test_subscription import Ear

Speed = Annotated[tuple[float, float, float], Unit("m/s"), Returns(after=0.5)]


class Robot:
    gain: Annotated[float, Returns(after=2.0, to=1.0)] = 5.0

    def __init__(self) -> None:
        self._speed = (0.0, 0.0, 0.0)
        self._fails = 0

    def get_velocity(self) -> Speed:
        return self._speed

    def set_velocity(self, speed: Speed) -> None:
        if self._fails and not any(speed):
            self._fails -= 1
            raise RuntimeError("the bus is down")
        self._speed = speed


class Timers(UserCode):
    """Time that passes when a test says so."""

    def __init__(self) -> None:
        self.now = 0.0
        self.due: dict[object, tuple[float, Callable[[Answer], object]]] = {}

    def refuse_after(self, wait: float, refuse: Callable[[Answer], object]) -> Callable[[], object]:
        key = object()
        self.due[key] = self.now + wait, refuse
        return lambda: self.due.pop(key, None)

    def passes(self, time_s: float) -> None:
        self.now += time_s
        for key, (at, refuse) in list(self.due.items()):
            if at <= self.now + 1e-9:
                del self.due[key]
                refuse(Answer("late", "timeout"))


Driven = tuple[Robot, Timers, Service]


@pytest.fixture
def driven() -> Driven:
    robot, timers, service = Robot(), Timers(), Service("r")
    service.values.user_code = timers
    Exported(service, robot)
    return robot, timers, service


def test_a_velocity_returns_to_rest(driven: Driven) -> None:
    robot, timers, service = driven
    service.set("velocity", "(1 0 0)")
    timers.passes(0.4)
    service.set("velocity.x", "2")
    timers.passes(0.4)
    assert service.get("velocity") == "(2.0 0.0 0.0)"
    timers.passes(0.1)
    assert service.get("velocity") == "(0.0 0.0 0.0)"
    assert robot._speed == (0.0, 0.0, 0.0)
    assert timers.due == {}


def test_listeners_are_sent_the_return(driven: Driven) -> None:
    _, timers, service = driven
    ear = Ear()
    answers: list[Answer] = []
    ask = PropertyRequest("velocity.listen?queue=9", "self", answers.append, ear)
    service.handle(ask)
    service.set("velocity", "(1 0 0)")
    timers.passes(0.5)
    (listener,) = ear.listeners
    seen = [event.payload for event in iter(lambda: listener.take(0.0), None)]
    assert seen == ["(0.0 0.0 0.0)", "(1.0 0.0 0.0)", "(0.0 0.0 0.0)"]


def test_the_timeout_is_a_property(driven: Driven) -> None:
    _, timers, service = driven
    assert service.get("velocity.timeout") == "0.5"
    assert service.get("velocity.timeout.meta.unit") == '"s"'
    assert service.get("velocity.properties") == "(x y z timeout)"
    service.set("velocity", "(1 0 0)")
    service.set("velocity.timeout", "3")
    timers.passes(2.9)
    assert service.get("velocity.x") == "1.0"
    timers.passes(0.1)
    assert service.get("velocity.x") == "0.0"


@pytest.mark.parametrize("value", ["inf", "nan", "0", "-1", "-inf", "0.0"])
def test_a_timeout_that_is_not_positive_and_finite_is_refused(driven: Driven, value: str) -> None:
    _, timers, service = driven
    with pytest.raises(PropertyError) as refused:
        service.set("velocity.timeout", value)
    assert refused.value.code == "bad-value"
    assert service.get("velocity.timeout") == "0.5"
    service.set("velocity", "(1 0 0)")
    timers.passes(0.5)
    assert service.get("velocity.x") == "0.0"


def test_a_stated_value_is_returned_to(driven: Driven) -> None:
    robot, timers, service = driven
    service.set("gain", "7")
    timers.passes(2.0)
    assert robot.gain == 1.0


def test_a_return_that_fails_is_tried_again(driven: Driven) -> None:
    robot, timers, service = driven
    service.set("velocity", "(1 0 0)")
    robot._fails = 2
    timers.passes(0.5)
    timers.passes(0.5)
    assert robot._speed == (1.0, 0.0, 0.0)
    timers.passes(0.5)
    assert robot._speed == (0.0, 0.0, 0.0)
    assert timers.due == {}
