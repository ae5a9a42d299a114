"""Values that users write."""

from __future__ import annotations

import pytest

from rtkit.component import Time, TimedLong, TimedLongSeq, TimedString
from rtkit.component.geometry import TimedVelocity2D
from rtkit.errors import Malformed
from rtkit.probe.templates import Template, templates

NOW = Time(5, 6)


def value(text: str, cls: type):
    return Template(text, {"p": cls}).at(NOW)["p"]


def test_json_and_yaml_say_the_same():
    assert value("42", TimedLong) == TimedLong(NOW, 42)
    assert value('{"data": [1, 2]}', TimedLongSeq) == value("data: [1, 2]", TimedLongSeq)
    assert value("{data: {vx: 0.5}}", TimedVelocity2D).data.vx == 0.5
    assert value("hello", TimedString) == TimedString(NOW, "hello")


def test_time_is_that_of_the_writing():
    template = Template('{"tm": {time}, "data": 1}', {"p": TimedLong})
    assert template.at(Time(1, 2))["p"].tm == Time(1, 2)
    assert template.at(Time(3, 4))["p"].tm == Time(3, 4)


@pytest.mark.parametrize(
    "text",
    [
        "[1, 2",
        "2.5",
        "!!python/object/apply:os.system [ls]",
        "&a [*a]",
        "[&a [1], *a, *a]",
        "{data: 1, more: 2}",
        "99999999999",
        "__import__('os')",
    ],
)
def test_what_is_no_value(text):
    with pytest.raises(Malformed):
        value(text, TimedLong)


def test_lines_are_read_one_by_one_and_named_when_wrong():
    read = templates(["# nothing\n", "\n", "1\n", "x y\n"], {"p": TimedLong}, "way.txt")
    assert next(read).at(NOW)["p"].data == 1
    with pytest.raises(Malformed, match=r"way\.txt:4: x y: "):
        next(read)


@pytest.mark.parametrize(
    ("text", "cls", "told"),
    [
        ("{daat: 3}", TimedLong, r"TimedLong: no field daat \(did you mean data\?\); it has tm, d"),
        ("{vxx: 1}", TimedVelocity2D, r"no field vxx \(did you mean vx\?\); it has vx, vy, va"),
        ("{data: hello}", TimedLong, 'TimedLong.data: "hello" is not a value of type int32'),
    ],
)
def test_what_is_wrong_is_named(text: str, cls: type, told: str):
    with pytest.raises(Malformed, match=told):
        value(text, cls)


def test_each_port_has_its_type():
    with pytest.raises(Malformed, match="TimedString"):
        Template("1", {"a": TimedLong, "b": TimedString})
    values = Template("[1]", {"a": TimedLongSeq, "b": TimedLongSeq}).at(NOW)
    assert values["a"] == values["b"] == TimedLongSeq(NOW, (1,))
