"""Which requests go beside the loop, behind which others, and for how long."""

from __future__ import annotations

import math
from typing import Annotated

import pytest

from rtkit.property.annotations import Concurrent
from rtkit.property.lanes import ALONE, NAMES, lane_of, wait_of
from rtkit.property.messages import Answer
from rtkit.property.objects import Exported
from rtkit.property.requests import PropertyRequest
from rtkit.property.service import Service


class Part:
    def __init__(self) -> None:
        self.size = 1.0


class Thing:
    def __init__(self) -> None:
        self.plain = [1.0, 2.0]
        self.part = Part()
        self.odd = 1.0

    @property
    def told(self) -> float:
        return 1.0

    def act(self) -> None: ...


def _ask(target: str, payload: str | None = None, until: float = math.inf) -> PropertyRequest:
    return PropertyRequest(target, payload, lambda answer: None, until=until)


@pytest.mark.parametrize(
    ("target", "payload", "lane"),
    [
        # What calls no user code is answered at once.
        ("plain", None, None), ("plain", "(1 2)", None), ("part.size", None, None),
        ("plain.listen", "self", None), ("act", None, None), ("act", "", None), ("%zz", None, None),
        # A property is got and set, and asked about, in the order of the requests.
        ("told", None, "told"), ("told?timeout=1", None, "told"), ("told.meta", None, "told"),
        ("told.listen", "self", "told"), ("service/told", None, "told"), ("plain.x", None, "plain"),
        # Names are looked for in turn; values of several hold up nobody who looks for names.
        ("properties", None, NAMES), ("nope", None, NAMES), ("part", None, NAMES),
        ("properties?values", None, f"{NAMES}properties?values"),
        ("part.properties.listen", "self", None),
    ],
)  # fmt: skip
def test_lanes_of_an_object(target: str, payload: str | None, lane: str | None) -> None:
    service = Service("service")
    Exported(service, Thing())
    assert lane_of(service.values, _ask(target, payload)) == lane


def test_requests_of_what_may_be_read_by_several_at_once_have_a_lane_each() -> None:
    class Found:
        def get_best(self, of: str = "") -> Annotated[float, Concurrent()]:
            return 1.0

        def set_best(self, value: float) -> None: ...

    service = Service()
    Exported(service, Found())
    lanes = [lane_of(service.values, _ask(each)) for each in ("best", "best", "best?of=all")]
    assert len(set(lanes)) == 3
    assert all(lane and lane.startswith(ALONE) for lane in lanes)
    assert lane_of(service.values, _ask("best", "2")) == "best"


def test_an_attribute_that_becomes_something_else_leaves_the_loop() -> None:
    class Odd(float):
        pass

    service, thing = Service(), Thing()
    Exported(service, thing)
    assert lane_of(service.values, _ask("odd")) is None
    thing.odd = Odd(2)
    assert lane_of(service.values, _ask("odd")) == "odd"


def test_a_service_of_its_own_values_needs_no_lanes() -> None:
    service = Service()
    service.add("speed", 1.0, "number")
    service.add("set_only", 1.0, "number", write=lambda value, given: None)
    for target, payload, lane in (
        ("speed", None, None), ("speed.meta", None, None), ("properties?all", None, NAMES),
        ("properties", None, None), ("set_only", None, None), ("set_only", "2", "set_only"),
        ("set_only.listen", "self", None),
    ):  # fmt: skip
        assert lane_of(service.values, _ask(target, payload)) == lane, target


@pytest.mark.parametrize(
    ("target", "until", "wait"),
    [("a", math.inf, 0.0), ("a?timeout=2", math.inf, 2.0), ("a?x=1&timeout=.5&y", math.inf, 0.5),
     ("a?timeout=red", math.inf, 0.0), ("a", 15.0, 5.0), ("a?timeout=2", 15.0, 2.0),
     ("a?timeout=0", math.inf, 0.001), ("a", 1.0, 0.001)],
)  # fmt: skip
def test_a_request_waits_as_long_as_somebody_waits_for_it(
    target: str, until: float, wait: float
) -> None:
    assert wait_of(_ask(target, until=until), now=10.0) == wait


def test_an_answer_that_comes_too_late_is_not_given() -> None:
    from rtkit.property.lanes import first_only

    answers: list[Answer] = []
    answer = first_only(answers.append)
    answer(Answer("late", "timeout"))
    answer(Answer("1"))
    assert answers == [Answer("late", "timeout")]
