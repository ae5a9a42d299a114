"""Values as text, as JSON, and their fields."""

from __future__ import annotations

import json
from enum import Enum

import pytest

from rtkit.component import Time, TimedDouble, TimedLongSeq, TimedOctetSeq, TimedString
from rtkit.component.geometry import Point2D, Pose2D, TimedPose2D
from rtkit.component.sensors import CameraImage
from rtkit.component.values.literal import Literal
from rtkit.component.values.value_text import field_reader, plain, text_of
from rtkit.errors import Malformed, NotFound

POSE = TimedPose2D(Time(12, 34), Pose2D(Point2D(1.0, 2.0), 0.5))


def test_a_stamp_and_data_are_printed_in_short():
    assert text_of(TimedDouble(Time(1, 5), 2.5)) == "[1.000000005] 2.5"
    assert text_of(TimedString(Time(0, 999_999_999), "ä\n")) == r"[0.999999999] 'ä\n'"
    assert text_of(POSE) == "[12.000000034] Pose2D(position=Point2D(x=1.0, y=2.0), heading=0.5)"


def test_long_contents_are_shortened_unless_they_are_wanted():
    image = CameraImage(width=640, height=480, pixels=bytes(640 * 480))
    told = "CameraImage([0.000000000], 640 x 480, bpp 0, format '', fDiv 0.0, 307200 bytes)"
    assert text_of(image) == told
    assert "pixels=b'\\x00" in text_of(image, is_full=True)
    value = TimedLongSeq(Time(), tuple(range(100)))
    assert text_of(value).endswith("14, 15, … 100 values]")
    assert text_of(value, is_full=True).endswith("98, 99]")


def test_an_enum_is_printed_by_its_name():
    class Colour(Enum):
        RED = 1

    assert text_of(Colour.RED) == "RED"


@pytest.mark.parametrize("value", [POSE, TimedOctetSeq(Time(1, 2), bytes(range(256)))])
def test_what_is_plain_can_be_read_again(value):
    text = json.dumps(plain(value))
    assert Literal(type(value), text).at(Time(9, 9)) == value


def test_fields():
    assert field_reader("data.position.x")(POSE) == 1.0
    assert field_reader("tm.sec")(POSE) == 12
    assert field_reader("data[2]")(TimedLongSeq(Time(), (5, 6, 7))) == 7


@pytest.mark.parametrize("text", ["", ".", "a.", "[", "a[b]", "a b", "[0]", "a[0].[1]", "a[-1]"])
def test_what_is_no_field(text):
    with pytest.raises(Malformed, match="Bad field"):
        field_reader(text)


@pytest.mark.parametrize("text", ["x", "data.position.z", "data[0]", "data.heading.x"])
def test_a_field_that_is_not_there(text):
    with pytest.raises(NotFound, match="no field"):
        field_reader(text)(POSE)
