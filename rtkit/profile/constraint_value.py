"""Tests values against constraints. Values and literals are text; numbers compare as numbers.

A test that is always true, or always false, for this kind of parameter is ignored: a bound that
is no number, a word where numbers are wanted (authors write notes there). A test that says nothing
is left out of the constraint around it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Sequence

from rtkit.profile import constraint_model as c
from rtkit.rtc.nearest import did_you_mean

_Number = int | float
_Order = Callable[[_Number, _Number], bool]
_ORDERS: dict[str, _Order] = {
    "propertyIsLessThan": lambda value, bound: value < bound,
    "propertyIsLessThanOrEqualTo": lambda value, bound: value <= bound,
    "propertyIsGreaterThan": lambda value, bound: value > bound,
    "propertyIsGreaterThanOrEqualTo": lambda value, bound: value >= bound,
}
_LEAST = _ORDERS["propertyIsGreaterThanOrEqualTo"]
_MOST = _ORDERS["propertyIsLessThanOrEqualTo"]
_OTHERS = "*"
_EQUAL = "propertyIsEqualTo"
_TRUTHS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
_SPELLINGS = {**_TRUTHS, "1": True, "0": False}
_INTEGER = re.compile(r"\s*[+-]?[0-9]{1,400}\s*", re.ASCII)


def allows(
    constraint: c.Constraint, value: str | Sequence[str], *, wants_number: bool = False
) -> bool:
    """Return whether `value`, a text or the elements of a list, satisfies `constraint`.

    One test holds for each element; a list of constraints holds element by element, as far as
    both go, unless it only names values: then it lists what each may be, as authors mean it.
    A hash holds for ``key:value`` elements whose key it names, and says nothing of others; the key
    ``*`` names all others, the empty one a text that begins with a brace and is no JSON object.

    Args:
        constraint: Constraint to check.
        value: Value to test.
        wants_number: Nothing but numbers can be values, so words test nothing.
    """
    items = (value,) if isinstance(value, str) else tuple(value)
    return _verdict(constraint, items, wants_number) is not False


def broken_sentence(constraint: c.Constraint, value: str | Sequence[str]) -> str:
    """Return the sentence of what `value` breaks; empty where the author gave none.

    In ``and(or("Sentence.", c1), …)`` a text that ends with a full stop stands before what it says:
    no value is such a text.
    """
    content = constraint.content
    test = content.test if isinstance(content, c.ConstraintUnit) else None
    if not isinstance(test, c.Logical) or allows(constraint, value):
        return ""
    if test.kind == "And":
        return next(filter(None, (broken_sentence(each, value) for each in test.constraints)), "")
    first = test.constraints[0].content if test.kind == "Or" else None
    stated = first.test if isinstance(first, c.ConstraintUnit) else None
    if not isinstance(stated, c.Comparison) or not stated.literal.endswith("."):
        return ""
    hint = did_you_mean(value, _choices(test.constraints[1:])) if isinstance(value, str) else ""
    return stated.literal.removesuffix(".") + hint


def _choices(parts: Iterable[c.Constraint]) -> Iterable[str]:
    """Yield the values that these name, of which one is enough."""
    for part in parts:
        test = part.content.test if isinstance(part.content, c.ConstraintUnit) else None
        if isinstance(test, c.Comparison) and test.kind == _EQUAL:
            yield test.literal
        elif isinstance(test, c.Logical) and test.kind == "Or":
            yield from _choices(test.constraints)


def _verdict(constraint: c.Constraint, items: tuple[str, ...], wants_number: bool) -> bool | None:
    """Return whether it holds, None where it says nothing."""
    content = constraint.content
    if isinstance(content, c.ConstraintUnit):
        return _all(_holds(content.test, item, wants_number) for item in items)
    if content.kind == "ConstraintHashType":
        return _all(_entry(content, item, wants_number) for item in _entries(items))
    pairs = zip(content.constraints, items, strict=False)
    each = _all(_verdict(part, (item,), wants_number) for part, item in pairs)
    if each is False and _only_names_values(content):
        choice = c.Logical("Or", content.constraints)
        return _all(_holds(choice, item, wants_number) for item in items)
    return each


def _all(verdicts: Iterable[bool | None]) -> bool | None:
    known = [verdict for verdict in verdicts if verdict is not None]
    return all(known) if known else None


def _only_names_values(group: c.ConstraintGroup) -> bool:
    for part in group.constraints:
        unit = part.content
        test = unit.test if isinstance(unit, c.ConstraintUnit) else None
        if not (isinstance(test, c.Comparison) and test.kind == _EQUAL):
            return False
    return True


def _entries(items: tuple[str, ...]) -> Iterable[tuple[str, str]]:
    """Yield key and value of each ``key:value`` of a text or list, brackets or none.

    Those of a JSON object are texts, or JSON again.
    """
    for item in items:
        if item.lstrip().startswith("{"):
            try:
                found = json.loads(item)
            except (ValueError, RecursionError):
                yield "", item
            else:
                for key, value in found.items():
                    yield key, value if isinstance(value, str) else json.dumps(value)
                continue
        for part in item.strip().removeprefix("{").removesuffix("}").split(","):
            key, colon, value = part.partition(":")
            if colon:
                yield key.strip().strip('"'), value.strip().strip('"')


def _entry(group: c.ConstraintGroup, entry: tuple[str, str], wants_number: bool) -> bool | None:
    key, value = entry
    units = [part.content for part in group.constraints]
    keyed = [unit for unit in units if isinstance(unit, c.ConstraintUnit)]
    if key and not any(unit.key == key for unit in keyed):
        key = _OTHERS
    tests = [unit.test for unit in keyed if unit.key == key]
    return _all(_holds(test, value, wants_number) for test in tests)


def _holds(test: c.ConstraintTest, text: str, wants_number: bool) -> bool | None:
    match test:
        case c.Comparison():
            return _compare(test, text, wants_number)
        case c.Between(lower, upper):
            return _all((_order(text, lower, _LEAST), _order(text, upper, _MOST)))
        case c.Like():
            return _is_like(test, text)
        case c.IsNull():
            return not text
        case c.Logical(kind, constraints):
            verdicts = [_verdict(part, (text,), wants_number) for part in constraints]
            if kind == "And":
                return _all(verdicts)
            known = [verdict for verdict in verdicts if verdict is not None]
            if not known:
                return None
            return any(known) if kind == "Or" else not any(known)


def _compare(test: c.Comparison, text: str, wants_number: bool) -> bool | None:
    order = _ORDERS.get(test.kind)
    if order is not None:
        return _order(text, test.literal, order)
    value, literal = _number(text), _number(test.literal)
    if wants_number and literal is None:
        return None
    is_equal = _is_same(test, text)
    if value is not None and literal is not None:
        is_equal = value == literal
    return is_equal if test.kind == _EQUAL else not is_equal


def _order(text: str, literal: str, order: _Order) -> bool | None:
    """Compare numbers; a bound that is no number bounds nothing."""
    value, bound = _number(text), _number(literal)
    if bound is None:
        return None
    return value is not None and order(value, bound)


def _is_same(test: c.Comparison, text: str) -> bool:
    one, other = text.strip(), test.literal.strip()
    if test.match_case:
        return one == other
    one, other = one.casefold(), other.casefold()
    if other in _TRUTHS and one in _SPELLINGS:
        return _SPELLINGS[one] == _TRUTHS[other]
    return one == other


def _number(text: str) -> _Number | None:
    if _INTEGER.fullmatch(text):
        return int(text)
    if not text.isascii() or "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return None


def _is_like(test: c.Like, text: str) -> bool:
    """Match in one pass that goes back to the last wild card only, so that it takes no ages."""
    wanted = _letters(test)
    place = at = 0
    last_wild, tried = -1, 0
    while at < len(text):
        letter, is_mark = wanted[place] if place < len(wanted) else ("", False)
        if is_mark and letter == test.wild_card:
            last_wild, tried = place, at
            place += 1
        elif letter and (is_mark or letter == text[at]):
            place, at = place + 1, at + 1
        elif last_wild >= 0:
            tried += 1
            place, at = last_wild + 1, tried
        else:
            return False
    return all(is_mark and letter == test.wild_card for letter, is_mark in wanted[place:])


def _letters(test: c.Like) -> list[tuple[str, bool]]:
    """Return the letters of a pattern, and of each whether it is a wild card or single mark."""
    letters = iter(test.literal)
    marks = (test.wild_card, test.single_char)
    return [
        (next(letters, ""), False) if letter == test.escape_char else (letter, letter in marks)
        for letter in letters
    ]
