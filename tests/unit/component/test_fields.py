"""Fields of data types."""

from __future__ import annotations

import pytest

from rtkit.component import Time, TimedBoolean, TimedLong, TimedLongSeq, TimedString
from rtkit.component.geometry import TimedPose2D
from rtkit.component.values.fields import check_field, numbers
from rtkit.errors import Malformed, NotFound


@pytest.mark.parametrize(
    ("cls", "text"),
    [
        (TimedLong, "data"),
        (TimedLong, "tm.sec"),
        (TimedPose2D, "data.position.x"),
        (TimedLongSeq, "data[7]"),
        (bytes, "any.thing"),
    ],
)
def test_fields_that_a_type_has(cls: type, text: str):
    check_field(cls, text)


@pytest.mark.parametrize(
    ("cls", "text", "told"),
    [
        (TimedLong, "daat", r"no field daat: TimedLong has tm, data \(did you mean data\?\)"),
        (TimedPose2D, "data.position.z", "no field data.position.z: Point2D has x, y"),
        (TimedPose2D, "data[0]", "Pose2D has position, heading"),
        (TimedLong, "data.x", "int32 has no fields"),
        (TimedLongSeq, "data[0].x", "int32 has no fields"),
    ],
)
def test_fields_that_a_type_has_not(cls: type, text: str, told: str):
    with pytest.raises(NotFound, match=told):
        check_field(cls, text)


def test_what_is_no_field_at_all():
    with pytest.raises(Malformed, match="Bad field"):
        check_field(TimedLong, "a..b")


def test_numbers_of_a_value():
    assert dict(numbers(TimedLong(Time(1, 2), 3))) == {"data": 3}
    assert dict(numbers(TimedLongSeq(Time(), (4, 5)))) == {"data[0]": 4, "data[1]": 5}
    assert dict(numbers(TimedBoolean(Time(), True))) == {"data": 1.0}
    assert dict(numbers(TimedString(Time(), "x"))) == {}
    assert dict(numbers(7, "data.x")) == {"data.x": 7}
