"""Names of data types."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from rtkit.component import TimedLong, TimedPose2D
from rtkit.component.values.typenames import register, type_by_name, type_name
from rtkit.errors import Malformed
from rtkit.rtc.data_types import is_same_type, scoped_name


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("IDL:RTC/TimedLong:1.0", "RTC::TimedLong"),
        ("RTC::TimedLong", "RTC::TimedLong"),
        ("::RTC::TimedLong", "RTC::TimedLong"),
        (" TimedLong ", "TimedLong"),
        ("IDL:a/b/C:1.0", "a::b::C"),
        ("idl:RTC/X:2.10", "RTC::X"),
        ("IDL:RTC/X", "RTC::X"),
        ("", ""),
        ("any", ""),
    ],
)
def test_scoped_names(text, name):
    assert scoped_name(text) == name


@pytest.mark.parametrize("text", ["IDL:RTC/TimedLong:1.0", "RTC::TimedLong", "TimedLong"])
def test_the_class_is_found_by_any_form(text):
    assert type_by_name(text) is TimedLong


def test_names_of_classes():
    assert type_name(TimedPose2D) == "IDL:RTC/TimedPose2D:1.0"
    assert type_name(bytes) == "any"
    assert type_by_name("IDL:RTC/NoSuch:1.0") is None
    assert type_by_name("") is None


def test_a_class_of_ones_own_is_known_by_module_and_name():
    @dataclass
    class Reading:
        value: float

    assert type_name(Reading) == "IDL:test_typenames/Reading:1.0"
    assert type_by_name("test_typenames::Reading") is Reading
    assert type_by_name("Reading") is Reading


def test_a_bare_name_that_two_modules_use_names_neither():
    one, other = type("Twice", (), {}), type("Twice", (), {})
    register(one, "a::Twice")
    register(other, "b::Twice")
    assert type_by_name("Twice") is None
    assert type_by_name("IDL:b/Twice:1.0") is other
    with pytest.raises(Malformed):
        register(one, "any")


def test_same_types():
    assert is_same_type("IDL:RTC/TimedLong:1.0", "RTC::TimedLong")
    assert is_same_type("TimedLong", "RTC::TimedLong")
    assert is_same_type("", "RTC::TimedLong")
    assert not is_same_type("Mine::TimedLong", "RTC::TimedLong")
    assert not is_same_type("TimedLong", "RTC::TimedLongSeq")
