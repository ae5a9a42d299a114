"""Which values satisfy which constraints."""

from __future__ import annotations

import pytest

from rtkit.profile.constraint_model import (
    Comparison,
    Constraint,
    ConstraintUnit,
    IsNull,
    Like,
    Logical,
)
from rtkit.profile.constraint_model import ConstraintGroup as Group
from rtkit.profile.constraint_text import parse_constraint
from rtkit.profile.constraint_value import allows, broken_sentence


def unit(test: Comparison | Like | IsNull | Logical) -> Constraint:
    return Constraint(ConstraintUnit(test))


@pytest.mark.parametrize(
    ("rule", "good", "bad"),
    [
        ("100", ["100", "1e2", "100.0"], ["99", "x", ""]),
        ("x>1", ["2", "1.01", "inf"], ["1", "0", "nan", "one"]),
        ("x>=1", ["1"], ["0.9"]),
        ("x<-1", ["-2"], ["-1", "0"]),
        ("0<=x<=100", ["0", "100", "50.5"], ["-0.1", "100.1", "nan", "", "x"]),
        ("0<x<100", ["0.1"], ["0", "100"]),
        ("(a,b,c)", ["a", " b ", "C"], ["d", "", "a,b"]),
        ("(1,2)", ["1", "2.0"], ["3"]),
        ("a<x<b", ["anything"], []),
        ("a<x<9", ["8"], ["9", "anything"]),
        ("(true,false)", ["1", "OFF", "true"], ["2"]),
        ("'A'", ["A"], ["a"]),
        ("x!=3", ["4", "x"], ["3", "3.0"]),
        ("9007199254740993", ["9007199254740993"], ["9007199254740992"]),
        ("1000", ["1e3"], ["1_000", "\u0661"]),
        ('like("a*b")', ["ab", "acb", "abab"], ["ba", "abc"]),
        ("not(or(null(),x<0))", ["1"], ["", "-1"]),
        ("and(x>1,or(x<3,(7,8)))", ["2", "7"], ["1", "5"]),
        ("{a:x>0,b:(on,off)}", ["a:1", "{a:1,b:off}", "c:0", "0"], ["a:0", "a:1,b:-", "{b:3}"]),
        ("list(1<x<3,list(7))", ["2"], ["3"]),
        ("a,b,c", ["a", "c"], ["d"]),
    ],
)
def test_one_value(rule: str, good: list[str], bad: list[str]) -> None:
    constraint = parse_constraint(rule)
    assert constraint is not None
    assert [value for value in good if not allows(constraint, value)] == []
    assert [value for value in bad if allows(constraint, value)] == []


def test_lists_are_tested_element_by_element() -> None:
    each = parse_constraint("x>0,x<0")
    assert each is not None
    assert allows(each, ["1", "-1"])
    assert not allows(each, ["1", "1"])
    assert allows(each, ["1", "-1", "what"])
    one = parse_constraint("x>0")
    assert one is not None
    assert allows(one, ["1", "2"])
    assert not allows(one, ["1", "0"])


def test_a_list_that_only_names_values_is_a_choice_too() -> None:
    names = parse_constraint("a,b")
    assert names is not None
    assert allows(names, ["b", "a", "a"])
    assert allows(names, ["a", "b"])
    assert not allows(names, ["b", "c"])


@pytest.mark.parametrize(
    ("rule", "good", "bad"),
    [
        ("remark", ["1", "2"], []),
        ("x!=remark", ["1", "2"], []),
        ("not(remark)", ["1"], []),
        ("(1,auto)", ["1"], ["2"]),
        ("(some,words)", ["1"], []),
        ("and(remark,x>1)", ["2"], ["1"]),
    ],
)
def test_words_test_nothing_where_numbers_are_wanted(
    rule: str, good: list[str], bad: list[str]
) -> None:
    constraint = parse_constraint(rule)
    assert constraint is not None
    assert all(allows(constraint, value, wants_number=True) for value in good)
    assert not any(allows(constraint, value, wants_number=True) for value in bad)


def test_a_hash_says_nothing_of_a_value_without_keys() -> None:
    named = parse_constraint("{a:x>0}")
    assert named is not None
    assert allows(named, "0")


@pytest.mark.parametrize(
    ("text", "is_allowed"),
    [
        ('{"a": 1}', True),
        ("{}", True),
        ("", True),
        ("a:1", True),
        ('{"a": 1, "other": 1}', False),
        ("a:1,other:1", False),
        ('{"a": "0, other: 1"}', False),
        ('{"b": "1, other: 1"}', True),
        ('{"b": {"a": 0}}', True),
    ],
)
def test_the_key_of_a_star_names_all_others(text: str, is_allowed: bool) -> None:
    closed = parse_constraint('hash(key(a,x>0),key(b,like("*")),key("*",not(like("*"))))')
    assert closed is not None
    assert allows(closed, text) is is_allowed


@pytest.mark.parametrize(
    ("text", "is_allowed"),
    [
        ('{"a": 1}', True),
        ("{}", True),
        ("word", True),
        ('{"a": ', False),
        ("{a: 1}", False),
        ("[" * 9 + "{", True),
        ('{"a":' + "[" * 100_000, False),
    ],
)
def test_the_empty_key_names_what_is_in_braces_and_no_object(text: str, is_allowed: bool) -> None:
    rule = parse_constraint('hash(key("",not(like("*"))))')
    assert rule is not None
    assert allows(rule, text) is is_allowed


def test_a_sentence_has_the_word_that_was_meant() -> None:
    rule = parse_constraint('or("It is one of one, three.",(one,three),like("{*"))')
    assert rule is not None
    assert broken_sentence(rule, "thre") == "It is one of one, three (did you mean three?)"
    assert broken_sentence(rule, "zzz") == "It is one of one, three"


def test_forms_that_only_documents_have() -> None:
    small = unit(Comparison("propertyIsLessThan", "1"))
    assert allows(unit(Logical("Not", (small,))), "2")
    assert not allows(unit(Logical("Not", (small,))), "0")
    assert not allows(unit(Comparison("propertyIsNotEqualTo", "x")), "X")
    assert allows(unit(Comparison("propertyIsNotEqualTo", "x", match_case=True)), "X")
    assert allows(unit(IsNull()), "")
    assert not allows(unit(IsNull()), "0")
    assert allows(Constraint(Group("ConstraintListType", (small,))), "0")


@pytest.mark.parametrize(
    ("literal", "good", "bad"),
    [
        ("*" * 60 + "b", "a" * 5000 + "b", "a" * 5000),
        ("a*", "abc", "ba"),
        ("a?c", "abc", "abbc"),
        ("a!*", "a*", "ab"),
        ("a.c", "a.c", "abc"),
    ],
)
def test_patterns(literal: str, good: str, bad: str) -> None:
    constraint = unit(Like(literal, "*", "?", "!"))
    assert allows(constraint, good)
    assert not allows(constraint, bad)
