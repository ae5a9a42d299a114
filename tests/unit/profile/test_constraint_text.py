from __future__ import annotations

import pytest

from rtkit.errors import Malformed
from rtkit.profile.constraint_model import (
    Between,
    Comparison,
    Constraint,
    ConstraintGroup,
    ConstraintUnit,
    IsNull,
    Like,
    Logical,
)
from rtkit.profile.constraint_text import format_constraint, parse_constraint


def unit(
    test: Comparison | Between | Logical | Like | IsNull, key: str | None = None
) -> Constraint:
    return Constraint(ConstraintUnit(test, key))


def compare(kind: str, literal: str) -> Constraint:
    return unit(Comparison(f"propertyIs{kind}", literal))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("100", compare("EqualTo", "100")),
        ("x > 1", compare("GreaterThan", "1")),
        ("x>=-1.5", compare("GreaterThanOrEqualTo", "-1.5")),
        ("x<9", compare("LessThan", "9")),
        ("x<=9", compare("LessThanOrEqualTo", "9")),
        ("9>x", compare("LessThan", "9")),
        ("1 <= x <= 9", unit(Between("1", "9"))),
        ("9>=x>=1", unit(Between("1", "9"))),
        ("1<x<9", unit(Logical("And", (compare("GreaterThan", "1"), compare("LessThan", "9"))))),
        (
            "1<=x<9",
            unit(Logical("And", (compare("GreaterThanOrEqualTo", "1"), compare("LessThan", "9")))),
        ),
        (
            "1<x<=9",
            unit(Logical("And", (compare("GreaterThan", "1"), compare("LessThanOrEqualTo", "9")))),
        ),
        ("(a, b)", unit(Logical("Or", (compare("EqualTo", "a"), compare("EqualTo", "b"))))),
        ("(a)", compare("EqualTo", "a")),
        (
            "x>1,(a,b)",
            Constraint(
                ConstraintGroup(
                    "ConstraintListType",
                    (
                        compare("GreaterThan", "1"),
                        unit(Logical("Or", (compare("EqualTo", "a"), compare("EqualTo", "b")))),
                    ),
                )
            ),
        ),
        (
            "{el1: 1<=x<=2, el2:7}",
            Constraint(
                ConstraintGroup(
                    "ConstraintHashType",
                    (
                        unit(Between("1", "2"), "el1"),
                        unit(Comparison("propertyIsEqualTo", "7"), "el2"),
                    ),
                )
            ),
        ),
        ("", None),
        ("  ", None),
    ],
)
def test_both_ways(text: str, expected: Constraint | None) -> None:
    assert parse_constraint(text) == expected
    if expected is not None:
        assert parse_constraint(format_constraint(expected)) == expected


@pytest.mark.parametrize(
    "text", ["x>1", "1<=x<=9", "1<x<9", "(a,b)", "x>1,5", "{a:1<=x<2,b:(c,d)}"]
)
def test_the_usual_forms_stay_as_they_are(text: str) -> None:
    constraint = parse_constraint(text)
    assert constraint is not None
    assert format_constraint(constraint) == text


@pytest.mark.parametrize(
    "text",
    ["x>", "1<x>2", "(a", "(a,,b)", "a,", "{a}", "{:1}", "a:b", "()", "x=1", "((a))", ","],
)
def test_other_forms_are_malformed(text: str) -> None:
    with pytest.raises(Malformed, match="bad constraint"):
        parse_constraint(text)


@pytest.mark.parametrize(
    "constraint",
    [
        unit(IsNull()),
        unit(Like("a*", "*", "?", "!")),
        unit(Comparison("propertyIsNotEqualTo", "1")),
        unit(Logical("Not", (compare("EqualTo", "1"),))),
        unit(Logical("Or", (unit(Between("1", "2")), compare("EqualTo", "1")))),
        unit(Logical("And", (compare("LessThan", "1"), compare("LessThan", "2")))),
        Constraint(
            ConstraintGroup(
                "ConstraintListType", (Constraint(ConstraintGroup("ConstraintListType")),)
            )
        ),
    ],
)
def test_constraints_without_a_line(constraint: Constraint) -> None:
    with pytest.raises(Malformed, match="has no one-line form"):
        format_constraint(constraint)
