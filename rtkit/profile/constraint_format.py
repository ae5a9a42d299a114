"""Formats constraints on one line, so that `rtkit.profile.constraint_text` reads them back."""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.profile.constraint_model import (
    Between,
    Comparison,
    Constraint,
    ConstraintTest,
    ConstraintUnit,
    IsNull,
    Like,
    Logical,
)
from rtkit.profile.constraint_text import LIKE_MARKS, SIGNS
from rtkit.profile.constraint_tokens import VARIABLE, literal

_LOW = ("propertyIsGreaterThan", "propertyIsGreaterThanOrEqualTo")
_HIGH = ("propertyIsLessThan", "propertyIsLessThanOrEqualTo")
_TURNED = {_LOW[0]: "<", _LOW[1]: "<="}


def format_constraint(constraint: Constraint) -> str:
    """Write a constraint in one line, in the usual form where it has one."""
    content = constraint.content
    if isinstance(content, ConstraintUnit) or content.kind == "ConstraintHashType":
        return _format(constraint)
    return _joined(content.constraints) if len(content.constraints) > 1 else _format(constraint)


def _format(constraint: Constraint) -> str:
    content = constraint.content
    if isinstance(content, ConstraintUnit):
        text = _format_test(content.test)
        return text if content.key is None else f"key({literal(content.key)},{text})"
    if content.kind == "ConstraintListType":
        return f"list({_joined(content.constraints)})"
    pairs = _pairs(content.constraints)
    if pairs is None:
        return f"hash({_joined(content.constraints)})"
    return "{" + ",".join(pairs) + "}"


def _joined(parts: Iterable[Constraint]) -> str:
    return ",".join(map(_format, parts))


def _pairs(parts: Iterable[Constraint]) -> list[str] | None:
    """Return ``key:constraint`` of each part; None when one of them has no key."""
    found = []
    for part in parts:
        unit = part.content
        if not isinstance(unit, ConstraintUnit) or unit.key is None:
            return None
        found.append(f"{literal(unit.key)}:{_format_test(unit.test)}")
    return found


def _format_test(test: ConstraintTest) -> str:
    match test:
        case Between(lower, upper):
            return f"{literal(lower)}<={VARIABLE}<={literal(upper)}"
        case Comparison(kind, text, is_exact):
            value = literal(text, is_exact=is_exact)
            return f"{VARIABLE}{SIGNS[kind]}{value}" if kind in SIGNS else value
        case Like(pattern, wild_card, single_char, escape_char):
            marks = (wild_card, single_char, escape_char)
            parts = (pattern,) if marks == LIKE_MARKS else (pattern, *marks)
            return f"like({','.join(map(_quoted, parts))})"
        case IsNull():
            return "null()"
        case Logical(kind, parts):
            usual = _enumeration(parts) if kind == "Or" else _range(parts) if kind == "And" else ""
            return usual or f"{kind.lower()}({_joined(parts)})"


def _quoted(text: str) -> str:
    plain = literal(text)
    return plain if plain[:1] == '"' else f'"{plain}"'


def _comparisons(parts: Iterable[Constraint]) -> list[Comparison]:
    """Return the comparisons that these are; nothing when one is another test or has a key."""
    found = []
    for part in parts:
        unit = part.content
        if not isinstance(unit, ConstraintUnit) or unit.key is not None:
            return []
        if not isinstance(unit.test, Comparison):
            return []
        found.append(unit.test)
    return found


def _enumeration(parts: tuple[Constraint, ...]) -> str:
    found = _comparisons(parts)
    if len(found) < 2 or any(each.kind != "propertyIsEqualTo" for each in found):
        return ""
    return "(" + ",".join(map(_format_test, found)) + ")"


def _range(parts: tuple[Constraint, ...]) -> str:
    """Return ``low<x<high``; both ends included would be read as between, another test."""
    found = _comparisons(parts)
    if len(found) != 2 or found[0].kind not in _LOW or found[1].kind not in _HIGH:
        return ""
    low, high = found
    if (low.kind, high.kind) == (_LOW[1], _HIGH[1]):
        return ""
    bottom = literal(low.literal, is_exact=low.match_case)
    top = literal(high.literal, is_exact=high.match_case)
    return f"{bottom}{_TURNED[low.kind]}{VARIABLE}{SIGNS[high.kind]}{top}"
