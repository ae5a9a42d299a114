"""Whether values satisfy constraints. Values and literals are text; numbers compare as numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from rtkit.profile.constraint_model import (
    Between,
    Comparison,
    Constraint,
    ConstraintGroup,
    IsNull,
    Like,
    Logical,
)

_Test = Comparison | Between | Like | IsNull | Logical
_Order = Callable[[float, float], bool]
_ORDERS: dict[str, _Order] = {
    "propertyIsLessThan": float.__lt__,
    "propertyIsLessThanOrEqualTo": float.__le__,
    "propertyIsGreaterThan": float.__gt__,
    "propertyIsGreaterThanOrEqualTo": float.__ge__,
}


def allows(constraint: Constraint, value: str | Sequence[str]) -> bool:
    """Whether `value`, a text or the elements of a list, satisfies `constraint`.

    One test holds for each element; a list of constraints holds element by element, as far as
    both go. A hash says nothing about a value without keys.
    """
    content = constraint.content
    items = [value] if isinstance(value, str) else value
    if isinstance(content, ConstraintGroup):
        if content.kind != "ConstraintListType":
            return True
        return all(map(allows, content.constraints, items))
    return all(_holds(content.test, item) for item in items)


def _holds(test: _Test, text: str) -> bool:
    match test:
        case Comparison():
            return _compare(test, text)
        case Between(lower, upper):
            return _order(text, lower, float.__ge__) and _order(text, upper, float.__le__)
        case Like():
            return _pattern(test).fullmatch(text) is not None
        case IsNull():
            return not text
        case Logical(kind, constraints):
            results = [allows(part, text) for part in constraints]
            if kind == "And":
                return all(results)
            return any(results) if kind == "Or" else not any(results)


def _compare(test: Comparison, text: str) -> bool:
    order = _ORDERS.get(test.kind)
    if order is not None:
        return _order(text, test.literal, order)
    value, literal = _number(text), _number(test.literal)
    is_equal = value == literal if None not in (value, literal) else _same(test, text)
    return is_equal if test.kind == "propertyIsEqualTo" else not is_equal


def _order(text: str, literal: str, order: _Order) -> bool:
    """Compare numbers; a bound that is no number bounds nothing."""
    value, bound = _number(text), _number(literal)
    return bound is None or (value is not None and order(value, bound))


def _same(test: Comparison, text: str) -> bool:
    one, other = text.strip(), test.literal
    return one == other if test.match_case else one.casefold() == other.casefold()


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _pattern(test: Like) -> re.Pattern[str]:
    wild = {test.wild_card: ".*", test.single_char: "."}
    parts = []
    letters = iter(test.literal)
    for letter in letters:
        if letter == test.escape_char:
            parts.append(re.escape(next(letters, "")))
        else:
            parts.append(wild.get(letter) or re.escape(letter))
    return re.compile("".join(parts), re.DOTALL)
