"""Sentences of the operator: what they mean, and what is said of those that mean nothing."""

from __future__ import annotations

import pytest
from manipulation.language import (
    Call,
    Define,
    Designate,
    Forget,
    Go,
    PickUp,
    Take,
    Target,
    body_of,
    endless,
    parse,
)

from rtkit.errors import Malformed

HERE = Target("at", (3, 4))
DEFINED = {"switch": ("A", "B", "X", "Y")}


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("designate object at (3 4) A", Designate("object", ((3, 4),), "A")),
        (
            "designate object at (3 3) (3 4) big box",
            Designate("object", ((3, 3), (3, 4)), "big box"),
        ),
        ("designate object at (3,4)", Designate("object", ((3, 4),), "")),
        ("designate wall at (5 1) (5 2)", Designate("wall", ((5, 1), (5, 2)), "")),
        (
            "designate place at (8 1) the light switch",
            Designate("place", ((8, 1),), "light switch"),
        ),
        ("forget the light switch", Forget("light switch")),
        ("pick up the red block", PickUp("red block")),
        ("take A to (3 4)", Take("A", HERE)),
        ("take A to the tray", Take("A", Target("in", None, "tray"))),
        ("take A near the light switch", Take("A", Target("near", None, "light switch"))),
        ("take A left of B", Take("A", Target("left of", None, "B"))),
        ("take A to (3 4) clearing into aside", Take("A", HERE, "aside")),
        ("take A to where B was", Take("A", Target("was", None, "B"))),
        ("leave it near the light switch", Take("it", Target("near", None, "light switch"))),
        ("leave it at (3 4)", Take("it", HERE)),
        ("go to (3 4)", Go(HERE)),
        ("go beside B", Go(Target("beside", None, "B"))),
        ('switch A "red block" (4 5) Y', Call("switch", ("A", "red block", (4, 5), "Y"))),
        ("define home = go to (1 1)", Define("home", (), "go to (1 1)")),
    ],
)
def test_a_sentence_has_a_meaning(text: str, meaning: object) -> None:
    assert parse(text, DEFINED) == meaning


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "begins with a word"),
        ("(3 4)", "begins with a word"),
        ("tak A to (3 4)", "did you mean take?"),
        ("swich A B X Y", "did you mean switch?"),
        ("switch A B X", "takes 4 arguments, not 3: switch A B X Y"),
        ("take A", "take NAME to"),
        ("take to (3 4)", "take NAME to"),
        ("take A to", "what?"),
        ("take A to (3 4) now", "more after (3 4)"),
        ("take A to (3 4) clearing", "clearing into REGION"),
        ("take A to (3", "a place is (x y)"),
        ("take A to (x y)", "a place is (x y)"),
        ("pick A", "pick up NAME"),
        ("leave A at (3 4)", "leave it"),
        ("designate A at (3 4)", "object, bar, wall, place, region"),
        ("designate object A", "there is no place"),
        ("designate place at (1 1) (2 2) two", "several are a region"),
        ("designate wall at (1 1) W", "no name"),
        ("go to (1 1); go to (2 2)", "in a definition only"),
        ("define = go to (1 1)", "a definition is"),
        ("define take A = pick up A", "a command already"),
        ("define f A A = pick up A", "one name"),
        ("cancel q1", "stands alone"),
    ],
)
def test_a_sentence_without_a_meaning_is_refused_with_a_reason(text: str, why: str) -> None:
    with pytest.raises(Malformed, match=why.replace("(", r"\(").replace(")", r"\)")):
        parse(text, DEFINED)


def test_a_definition_gets_its_arguments() -> None:
    body = "take A to X; go to X"
    assert body_of(body, ("A", "X"), ("box", (3, 4)), {}) == [Take("box", HERE), Go(HERE)]


def test_a_definition_holds_nothing_that_is_for_the_operator() -> None:
    with pytest.raises(Malformed, match="for the operator"):
        body_of("forget A", ("A",), ("A",), {})
    with pytest.raises(Malformed, match="no command between"):
        body_of("go to (1 1);", (), (), {})


def test_a_cycle_of_calls_is_found() -> None:
    definitions = {"a": ((), "go to (1 1); b"), "b": ((), "c"), "c": ((), "a"), "d": ((), "a")}
    assert endless(definitions, "a") == ["a", "b", "c", "a"]
    assert endless(definitions, "d") == []
    assert endless({"e": ((), "take e to (1 1)")}, "e") == []
