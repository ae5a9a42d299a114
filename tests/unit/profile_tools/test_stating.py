"""Properties of a system: stated in their place, added at the end, removed."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed, NotFound
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rts_model import ComponentInstance, RtsProfile
from rtkit.profile_tools.stating import Statement, stated, statement

MOTOR = ComponentInstance(
    "RTC:::Motor:", "localhost/Motor0.rtc", "Motor0", properties=(ExtensionProperty("a", "1"),)
)
SYSTEM = RtsProfile(
    "RTSystem:a:b:1",
    "0.2",
    "2025-01-01T00:00:00",
    "2025-01-01T00:00:00",
    components=(MOTOR,),
    properties=(ExtensionProperty("x", "1"), ExtensionProperty("y", "2")),
)


def told(*texts: str, removed: tuple[str, ...] = ()) -> RtsProfile:
    said = [statement(each) for each in texts]
    return stated(SYSTEM, [*said, *(statement(each, is_removal=True) for each in removed)])


@pytest.mark.parametrize(
    ("text", "is_removal", "meant"),
    [
        ("Motor0:rtkit.restart=always", False, Statement("Motor0", "rtkit.restart", "always")),
        ("x=a:b=c", False, Statement("", "x", "a:b=c")),
        ("x=", False, Statement("", "x", "")),
        ("Motor0:x", True, Statement("Motor0", "x", None)),
    ],
)
def test_what_is_meant(text: str, is_removal: bool, meant: Statement) -> None:
    assert statement(text, is_removal=is_removal) == meant


@pytest.mark.parametrize(
    ("text", "is_removal"), [("x", False), ("=1", False), ("Motor0:=1", False), ("x=1", True)]
)
def test_what_is_neither_is_refused(text: str, is_removal: bool) -> None:
    with pytest.raises(Malformed, match=r"not \[INSTANCE:\]KEY"):
        statement(text, is_removal=is_removal)


def test_what_is_there_changes_in_its_place_and_what_is_new_comes_last() -> None:
    profile = told("x=5", "z=3", "Motor0:b=2")
    assert [(p.name, p.value) for p in profile.properties] == [("x", "5"), ("y", "2"), ("z", "3")]
    assert [(p.name, p.value) for p in profile.components[0].properties] == [("a", "1"), ("b", "2")]


def test_what_is_removed_is_gone() -> None:
    profile = told(removed=("x", "Motor0:a"))
    assert [p.name for p in profile.properties] == ["y"]
    assert profile.components[0].properties == ()


@pytest.mark.parametrize(
    ("text", "is_removal", "why"),
    [
        ("Arm:a=1", False, r"no component named Arm \(components: Motor0\)"),
        ("Motor0:b", True, "Motor0 has no property b"),
        ("z", True, "the system has no property z"),
    ],
)
def test_what_is_not_there_is_told(text: str, is_removal: bool, why: str) -> None:
    with pytest.raises(NotFound, match=why):
        stated(SYSTEM, [statement(text, is_removal=is_removal)])
