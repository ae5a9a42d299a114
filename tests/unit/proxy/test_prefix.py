"""PrefixedNames on the two sides of a proxy, and what may be set through it."""

from __future__ import annotations

import pytest

from rtkit.property.codes import PropertyError
from rtkit.property.values import Value
from rtkit.proxy.prefix import Allowed, PrefixedNames


@pytest.mark.parametrize(
    ("patterns", "name", "may"),
    [
        ((), "speed", False),
        (("speed",), "speed", True),
        (("speed",), "speed.x", False),
        (("arm.*",), "arm.angle", True),
        (("arm.*",), "arm", False),
        (("arm.*",), "arm.properties", True),
        (("arm*",), "arm.properties", True),
        (("arm.a*",), "arm.properties", False),
        (("a?m.*",), "arm.properties", False),
        (("p*",), "properties", False),
        (("properties",), "properties", False),
        (("*.properties",), "arm.properties", False),
        (("*",), "properties", True),
        (("speed", "*"), "arm.joint.properties", True),
    ],
)
def test_what_may_be_set(patterns: tuple[str, ...], name: str, may: bool) -> None:
    assert Allowed(patterns)(name) is may


def test_names_are_put_behind_a_prefix_and_taken_from_it() -> None:
    names = PrefixedNames("left.h%61nd")
    assert names.prefix == "left.hand"
    for name in ("speed", "arm.angle", "properties"):
        assert names.inward(names.outward(name)) == name
    assert names.inward("left.hand") == "properties"
    for other in ("left", "left.handle", "speed", "left.hand2.x"):
        with pytest.raises(PropertyError, match="no such property"):
            names.inward(other)
    assert PrefixedNames().inward("speed") == PrefixedNames().outward("speed") == "speed"
    with pytest.raises(PropertyError):
        PrefixedNames("a b")


def test_what_lies_above_a_prefix() -> None:
    names = PrefixedNames("left.hand")
    above = {"properties": "", "left": "left", "left.properties": "left"}
    for name, place in above.items():
        assert names.above(name) == place
    for name in ("left.hand", "left.hand.properties", "left.hand.x", "right", "left.meta"):
        assert names.above(name) is None
    assert PrefixedNames().above("properties") is None
    assert (names.listed(""), names.listed("left")) == ("(left)", "(hand)")


@pytest.mark.parametrize(
    ("place", "listing", "options", "told"),
    [
        ("", "(a b a.c)", {"all": True}, "(left left.hand left.hand.a left.hand.b left.hand.a.c)"),
        ("", "(a)", {"depth": 2}, "(left left.hand)"),
        ("left", "(a b a.c)", {"depth": 2}, "(hand hand.a hand.b)"),
        ("", "((a 1) (b (2 3)))", {"all": True, "values": True},
         "((left.hand.a 1) (left.hand.b (2 3)))"),
        ("", "((a 1) (b 2))", {"names": ("left.hand.b",), "values": True}, "((left.hand.b 2))"),
        ("left", "((a <meta/> 1))", {"all": True, "meta": True}, "((hand) (hand.a <meta/> 1))"),
        ("", "(a b)", {"all": True, "match": "*.b"}, "(left.hand.b)"),
    ],
)  # fmt: skip
def test_listings_seen_from_above(
    place: str, listing: str, options: dict[str, Value], told: str
) -> None:
    assert PrefixedNames("left.hand").widened(place, listing, options) == told


@pytest.mark.parametrize(
    ("place", "options", "asked"),
    [
        ("", {"all": True}, "all"),
        ("", {"names": ("left.hand.b",)}, "all"),
        ("", {"match": "*"}, ""),
        ("", {"depth": 2, "values": True}, ""),
        ("", {"depth": 3}, "depth=1"),
        ("left", {"depth": 3}, "depth=2"),
        ("left", {"depth": -1}, ""),
    ],
)
def test_the_owner_is_asked_for_what_is_shown_of_it(
    place: str, options: dict[str, Value], asked: str
) -> None:
    assert PrefixedNames("left.hand").shown_of_owner(place, options) == asked


def test_what_is_asked_for_above_and_is_not_there() -> None:
    with pytest.raises(PropertyError, match=r"left\.hand\.c"):
        PrefixedNames("left.hand").widened("", "(a b)", {"names": ("left.hand.c",)})
    with pytest.raises(PropertyError, match="depth is a number"):
        PrefixedNames("left.hand").widened("", "(a b)", {"depth": "deep"})
