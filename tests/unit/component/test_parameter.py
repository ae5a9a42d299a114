"""Configuration parameters: kinds and text."""

from __future__ import annotations

import pytest

from rtkit.component import Component, Parameter
from rtkit.component.configuration.kinds import kind_of
from rtkit.errors import Malformed


@pytest.mark.parametrize(
    ("default", "text", "value"),
    [
        (0, "42", 42),
        (0, " -7 ", -7),
        (0.0, "1e3", 1000.0),
        (0.0, "inf", float("inf")),
        ("", " as it is ", " as it is "),
        (False, "YES", True),
        (True, "off", False),
        (True, "0", False),
        ((1.0,), "1, 2.5,3", (1.0, 2.5, 3.0)),
        ((1.0,), "(1 2)", (1.0, 2.0)),
        ((1.0,), "[1,2]", (1.0, 2.0)),
        ((1,), "1,2", (1, 2)),
        ((), "1,2", (1.0, 2.0)),
        ((1.0,), "", ()),
    ],
)
def test_reading(default, text, value):
    read = kind_of(default).read(text)
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize(
    ("default", "text"),
    [
        (0, "4.5"),
        (0, ""),
        (0, "0x10"),
        (0, "1_000"),
        (0, "٣"),
        (0.0, "1,5"),
        (0.0, "1_0"),
        (0.0, "٣"),
        (False, "maybe"),
        (False, "2"),
        ((1.0,), "1;2"),
        ((1.0,), "(1,2"),
        ((1,), "1,2.5"),
    ],
)
def test_not_to_be_read(default, text):
    with pytest.raises(Malformed):
        kind_of(default).read(text)


@pytest.mark.parametrize("default", [0, -3, 0.1, 1e300, "a, b", True, False, (1.0, 0.1), (1, 2)])
def test_text_of_a_default_reads_back(default):
    kind = kind_of(default)
    assert kind.read(kind.write(default)) == default


def test_a_list_is_taken_as_a_tuple():
    assert Parameter([1.0, 2.0]).default == (1.0, 2.0)


@pytest.mark.parametrize("default", [None, {}, b"x", ("a",), (True,), 1j])
def test_what_cannot_be_a_parameter(default):
    with pytest.raises(Malformed, match="cannot be a"):
        Parameter(default)


class Sample(Component):
    gain = Parameter(1.0, unit="1/s", doc="How much", constraint="0<=x<=9", widget="slider.0.1")
    class_ = Parameter("a")


def test_a_parameter_reads_as_its_value():
    sample = Sample("Sample0", {"conf.default.gain": "2"})
    assert sample.gain == 2.0
    assert sample.configuration.sets["default"] == {"gain": "2", "class": "a"}
    assert Sample.gain.unit == "1/s"
    with pytest.raises(AttributeError, match="configuration set"):
        sample.gain = 3.0


def test_hints_go_into_hidden_sets():
    sets = Sample("Sample0").configuration.sets
    assert sets["__description__"] == {"gain": "How much [1/s]"}
    assert sets["__constraints__"] == {"gain": "0<=x<=9"}
    assert sets["__widget__"] == {"gain": "slider.0.1"}
    assert sets["__type__"] == {"gain": "double", "class": "string"}
