"""Values written as JSON."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import pytest

from rtkit.component import Char, Long, Time, TimedLong, timed
from rtkit.component.geometry import Pose2D, TimedPose2D, TimedVelocity2D, Velocity2D
from rtkit.component.values.literal import Literal, zero_value
from rtkit.errors import Malformed

NOW = Time(100, 5)


class Mood(Enum):
    GOOD = "good"
    BAD = "bad"


@dataclass
class Everything:
    flag: bool
    letter: Char
    raw: bytes
    mood: Mood
    pair: tuple[Long, str]
    items: list[Long]


@pytest.mark.parametrize(
    ("cls", "text", "value"),
    [
        (TimedLong, "3", TimedLong(NOW, 3)),
        (TimedLong, '{"data": 3}', TimedLong(NOW, 3)),
        (TimedLong, '{"tm": {"sec": 1, "nsec": 2}, "data": 3}', TimedLong(Time(1, 2), 3)),
        (timed.TimedDouble, "3", timed.TimedDouble(NOW, 3.0)),
        (timed.TimedString, '"grüß"', timed.TimedString(NOW, "grüß")),
        (timed.TimedBoolean, "true", timed.TimedBoolean(NOW, True)),
        (timed.TimedLongSeq, "[1, 2]", timed.TimedLongSeq(NOW, (1, 2))),
        (timed.TimedOctetSeq, "[1, 255]", timed.TimedOctetSeq(NOW, b"\1\xff")),
        (TimedVelocity2D, '{"vx": 1}', TimedVelocity2D(NOW, Velocity2D(1.0, 0.0, 0.0))),
        (TimedPose2D, "{}", TimedPose2D(NOW, Pose2D())),
        (Velocity2D, '{"va": 2.5}', Velocity2D(0.0, 0.0, 2.5)),
        (bytes, "[0, 1]", b"\0\1"),
        (
            Everything,
            '{"flag": false, "letter": "x", "raw": [7], "mood": "BAD", "pair": [1, "a"],'
            ' "items": [5]}',
            Everything(False, "x", b"\7", Mood.BAD, (1, "a"), [5]),
        ),
        (Everything, '{"mood": 1, "letter": "y"}', None),
    ],
)
def test_values(cls, text, value):
    read = Literal(cls, text).at(NOW)
    if value is None:
        assert (read.mood, read.letter, read.items, read.pair) == (Mood.BAD, "y", [], (0, ""))
    else:
        assert read == value
        assert all(
            type(getattr(read, n)) is type(getattr(value, n))
            for n in vars(cls).get("__slots__", ())
        )


@pytest.mark.parametrize(
    ("cls", "text", "named"),
    [
        (TimedLong, "__import__('os')", "TimedLong: not JSON"),
        (TimedLong, "[" * 100_000, "TimedLong: not JSON"),
        (TimedLong, '"3"', 'TimedLong.data: "3" is not a value of type int32'),
        (TimedLong, "true", "TimedLong.data: true"),
        (TimedLong, "3.5", "TimedLong.data: 3.5"),
        (TimedLong, '"zwölf"', 'TimedLong.data: "zwölf" is not a value of type int32'),
        (TimedLong, "3000000000", "TimedLong.data: 3000000000 is not a value of type int32"),
        (TimedLong, "null", "TimedLong.data: null"),
        (timed.TimedDouble, "1" + "0" * 400, "TimedDouble.data"),
        (timed.TimedBoolean, "1", "TimedBoolean.data: 1"),
        (timed.TimedChar, '"ab"', "TimedChar.data"),
        (timed.TimedLongSeq, "[1, true]", "TimedLongSeq.data[1]: true"),
        (timed.TimedLongSeq, "5", "TimedLongSeq.data: 5"),
        (timed.TimedOctetSeq, "[256]", "TimedOctetSeq.data: 256"),
        (timed.TimedOctetSeq, '"abc"', "TimedOctetSeq.data"),
        (TimedVelocity2D, '{"speed": 1}', "TimedVelocity2D.data: no field speed; it has vx, vy"),
        (TimedVelocity2D, '{"data": {"vx": "a"}}', 'TimedVelocity2D.data.vx: "a"'),
        (TimedLong, '{"data": 1, "tm": {"sec": -1}}', "TimedLong.tm.sec: -1"),
        (Everything, '{"mood": "UGLY"}', "Everything.mood: 'UGLY' is none of GOOD, BAD"),
        (Everything, '{"pair": [1]}', "Everything.pair: [1]"),
        (bytes, '"x"', "bytes:"),
    ],
)
def test_what_is_no_value(cls, text, named):
    with pytest.raises(Malformed) as caught:
        Literal(cls, text)
    assert str(caught.value).startswith(named)


def test_zero_values():
    assert zero_value(TimedLong, NOW) == TimedLong(NOW, 0)
    assert zero_value(Velocity2D, NOW) == Velocity2D()
    assert zero_value(bytes, NOW) == b""
    assert zero_value(timed.TimedStringSeq, NOW).data == ()
