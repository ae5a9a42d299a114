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
from rtkit.profile.constraint_text import MAX_DEPTH, format_constraint, parse_constraint


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
    "text",
    [
        "x>1",
        "x!=1",
        "1<=x<=9",
        "1<x<9",
        "(a,b)",
        "x>1,5",
        "{a:1<=x<2,b:(c,d)}",
        "not(x>1)",
        "and(x>1,x>2)",
        "or((a,b),x>1)",
        "null()",
        'like("a*")',
        'like("a%","%","_","!")',
        "list()",
        "list(list(1,2))",
        "hash(1,key(k,2))",
        "{}",
        "(\"a b\",'Exact',c)",
        '""',
        '{"a:b":"line\\n"}',
    ],
)
def test_the_usual_forms_stay_as_they_are(text: str) -> None:
    constraint = parse_constraint(text)
    assert constraint is not None
    assert format_constraint(constraint) == text


@pytest.mark.parametrize(
    "text",
    [
        *("x>", "1<x>2", "(a", "(a,,b)", "a,", "{a}", "{:1}", "a:b", "()", "x=1", "((a))", ","),
        *("1<2", "1<x<2<3", "1!=x<2", "nor(a)", "not()", "not(a,b)", "and(a)", "or(a", "like(a,b)"),
        *("{k:list(1)}", "key(a,key(b,1))", "null(a)", "x!1=2", "a)", '"a"b'),
        "not(" * (MAX_DEPTH + 1) + "a" + ")" * (MAX_DEPTH + 1),
    ],
)
def test_other_forms_are_malformed(text: str) -> None:
    with pytest.raises(Malformed, match="bad constraint"):
        parse_constraint(text)


@pytest.mark.parametrize(
    ("constraint", "text"),
    [
        (unit(IsNull()), "null()"),
        (unit(Like("a*", "*", "?", "!")), 'like("a*","*","?","!")'),
        (unit(Like("a*", "*", "?", "\\")), 'like("a*")'),
        (unit(Comparison("propertyIsNotEqualTo", "1")), "x!=1"),
        (unit(Comparison("propertyIsEqualTo", "A", match_case=True)), "'A'"),
        (unit(Logical("Not", (compare("EqualTo", "1"),))), "not(1)"),
        (unit(Logical("Or", (unit(Between("1", "2")), compare("EqualTo", "1")))), "or(1<=x<=2,1)"),
        (
            unit(Logical("And", (compare("LessThan", "1"), compare("LessThan", "2")))),
            "and(x<1,x<2)",
        ),
        (
            Constraint(
                ConstraintGroup(
                    "ConstraintListType", (Constraint(ConstraintGroup("ConstraintListType")),)
                )
            ),
            "list(list())",
        ),
    ],
)
def test_what_only_documents_have_has_a_form_of_its_own(constraint: Constraint, text: str) -> None:
    assert format_constraint(constraint) == text
    assert parse_constraint(text) == constraint


def test_both_ends_included_twice_is_not_between() -> None:
    ends = (compare("GreaterThanOrEqualTo", "1"), compare("LessThanOrEqualTo", "9"))
    constraint = unit(Logical("And", ends))
    assert format_constraint(constraint) == "and(x>=1,x<=9)"
    assert parse_constraint("and(x>=1,x<=9)") == constraint


def test_an_apostrophe_is_an_apostrophe() -> None:
    assert parse_constraint("it's") == compare("EqualTo", "it's")
    assert parse_constraint("'it") == compare("EqualTo", "'it")
