"""Create strings: what is read, what is refused."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed
from rtkit.rtc.create import CreateString, parse_create


def test_a_bare_type() -> None:
    create = parse_create("ConsoleIn")
    assert create == CreateString("ConsoleIn")
    assert (create.instance_name, create.place, create.address) == ("", "", "")
    assert str(create) == "ConsoleIn"


def test_six_fields() -> None:
    create = parse_create("RTC:Me:test:ConsoleIn:Python:1.0?instance_name=In0")
    assert (create.vendor, create.category, create.implementation_id) == ("Me", "test", "ConsoleIn")
    assert (create.language, create.version, create.instance_name) == ("Python", "1.0", "In0")


def test_empty_fields_match_anything() -> None:
    assert parse_create("RTC:::ConsoleIn::") == CreateString("ConsoleIn")
    assert str(parse_create("RTC:::ConsoleIn::")) == "ConsoleIn"


@pytest.mark.parametrize(
    "text",
    [
        "T?instance_name=x&manager_name=s&conf.default.a=1",
        "T?manager_name=s&instance_name=x&conf.default.a=1",
        "T?conf.default.a=1&manager_name=s&instance_name=x",
    ],
)
def test_options_stand_in_any_order(text: str) -> None:
    create = parse_create(text)
    assert (create.instance_name, create.place) == ("x", "s")
    assert create.options["conf.default.a"] == "1"


@pytest.mark.parametrize("key", ["manager", "manager_address"])
def test_the_address_of_a_manager(key: str) -> None:
    assert parse_create(f"T?{key}=host:2810").address == "host:2810"


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("a%26b%3Dc%25%3F", "a&b=c%?"),
        ("100%", "100%"),
        ("%zz", "%zz"),
        ("M%C3%B6tor", "Mötor"),
        ("%e2%82%acx%26", "€x&"),
        ("%n-%h.%M", "%n-%h.%M"),
        ("a=b", "a=b"),
        ("", ""),
        ("manager_%p", "manager_%p"),
    ],
)
def test_values_may_be_escaped(written: str, value: str) -> None:
    assert parse_create(f"T?key={written}").options["key"] == value


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "names no component type: ''"),
        ("?a=b", "names no component type"),
        ("RTC:a:b::c:d", "names no component type"),
        ("T?a=b?c=d", "more than one '?'"),
        ("T?", "option '' is not KEY=VALUE"),
        ("T?a", "option 'a' is not KEY=VALUE"),
        ("T?=b", "option '=b' is not KEY=VALUE"),
        ("T?a=b&", "option '' is not KEY=VALUE"),
        ("T?a=%F6", "%F6 is no UTF-8 (a per cent sign is %25) in create string: T?a=%F6"),
        ("T?a=x%C3&b=%B6", "%C3 is no UTF-8"),
        ("T?instance_name=", "option 'instance_name' has no value in create string"),
        ("T?a=&manager_name=", "option 'manager_name' has no value"),
        ("T?manager=", "option 'manager' has no value"),
        ("T?manager_address=", "option 'manager_address' has no value"),
        ("T?language=", "option 'language' has no value"),
        ("T?a=1&a=2", "option 'a' is given twice"),
        ("RTC:a:T", "needs RTC:vendor:category"),
        ("RTC:a:b:T:d:e:f", "needs RTC:vendor:category"),
        ("XTC:a:b:T:d:e", "needs RTC:vendor:category"),
    ],
)
def test_what_cannot_be_read(text: str, why: str) -> None:
    with pytest.raises(Malformed) as caught:
        parse_create(text)
    assert why in str(caught.value)


def test_options_are_set_and_removed() -> None:
    create = parse_create("T?a=1&b=2").with_options(b="", c="3")
    assert str(create) == "T?a=1&c=3"
