"""Expressions of state machines: grammar, unknown values, refusals with their place."""

from __future__ import annotations

import re
from typing import Any

import pytest

from rtkit.services.statemachine.expressions import Expression, plain_of, written

VALUES = {
    "robots/r1.location.x": 1.5,
    "light.on": True,
    "door.state": "open",
    "light.pose": (1, 2),
    "variables.n": 3,
}


def value(text: str) -> Any:
    return Expression(text).value(VALUES.get)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("robots/r1.location.x > 1", True),
        ("robots/r1.location.x>1 and not light.on", False),
        ("not (light.on and door.state = closed)", True),
        ('door.state = "open" or gone.away > 1', True),
        ("variables.n * 2 - 1 >= 5", True),
        ("variables.n / 2", 1.5),
        ("2 + 3 * 4", 14),
        ("-variables.n + 1 < -1", True),
        ("robots/r1.location.x?frame=world > 1", None),  # another property: not known
        ("gone.away > 1", None),
        ("gone.away > 1 and light.on", None),
        ("gone.away > 1 and not light.on", False),
        ("not gone.away > 1", None),
        ("light.on = 1", False),
        ("light.on < 2", None),
        ("light.on and 1", None),
        ("light.pose = 1", None),
        ("variables.n / 0", None),
        ("door.state < shut", True),
        ("light.on", True),
    ],
)
def test_expression_has_the_value(text: str, expected: Any) -> None:
    assert value(text) == expected
    assert type(value(text)) is type(expected)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("", "column 1: did not expect the end: nothing is there"),
        ("a.b >", "column 6: did not expect the end: a.b >"),
        ("1 < 2 < 3", "column 7: did not expect <: 1 < 2 < 3"),
        ("(a.b", "column 5: did not expect the end: (a.b"),
        ("a.b and and c.d", "column 9: did not expect and: a.b and and c.d"),
        ("__import__('os')", "column 12: cannot be read: __import__('os')"),
        ("a.b[0]", "column 4: cannot be read: a.b[0]"),
        ("a..b > 1", "column 2: cannot be read: a..b > 1"),
        ("f(1)", "column 2: did not expect (: f(1)"),
        ("1 + " * 300 + "1", "column 400: too long: … 1 + 1"),
        ("(" * 300 + "1" + ")" * 300, "too long"),
    ],
)
def test_what_is_no_expression_is_refused_with_its_place(text: str, place: str) -> None:
    with pytest.raises(ValueError, match=re.escape(place)):
        Expression(text)


def test_expression_tells_what_it_reads() -> None:
    read = Expression("a.b > variables.n and not (c/d.e = word)")
    assert (read.names, read.variables) == ({"a.b", "c/d.e"}, {"n"})


def test_numbers_stay_small() -> None:
    assert value(" * ".join(["9007199254740993"] * 30)) == float("inf")


@pytest.mark.parametrize(
    ("plain", "text"),
    [
        (True, "true"),
        (1, "1"),
        (-0.5, "-0.5"),
        ("a", "a"),
        ("a b", '"a b"'),
        ("1", '"1"'),
        ("true", '"true"'),
        ('"', '"\\""'),
        ("", '""'),
        ("a\r\n\tb\\n", '"a\\r\\n\\tb\\\\n"'),
    ],
)
def test_values_are_written_as_a_set_carries_them(plain: Any, text: str) -> None:
    assert written(plain) == text
    assert value(text) == plain


def test_plain_text_is_number_truth_or_text() -> None:
    assert [plain_of(each) for each in ("1", "1.5", "true", "x", "1_0")] == [
        1,
        1.5,
        True,
        "x",
        "1_0",
    ]


def test_brackets_without_end_are_refused() -> None:
    with pytest.raises(ValueError, match=r"column 52: more than 50 brackets inside each other: ."):
        Expression("(" * 199)


@pytest.mark.parametrize("number", ["9" * 400, "-" + "9" * 400])
def test_numbers_that_no_float_has_are_infinite(number: str) -> None:
    assert value(f"{number} * 1.5 + 1 / 2") == float(f"{number[:-399]}e999")
