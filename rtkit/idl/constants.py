"""Evaluates constant expressions."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from typing import Any

from rtkit.idl.model import Value

_OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "|": operator.or_,
    "^": operator.xor,
    "&": operator.and_,
    "<<": operator.lshift,
    ">>": operator.rshift,
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": lambda left, right: _divided(left, right),
    "%": lambda left, right: left - right * _divided(_whole(left), _whole(right)),
}
_FIXED = {"or": "|", "xor": "^", "and": "&"}
_LARGEST_SHIFT = 64
_OCTAL = re.compile("[0-7]+")
_ESCAPE = re.compile(r"\\(x[0-9a-fA-F]{1,2}|u[0-9a-fA-F]{1,4}|[0-7]{1,3}|.)")
_CHARACTERS = {"n": "\n", "t": "\t", "v": "\v", "b": "\b", "r": "\r", "f": "\f", "a": "\a"}


class BadConstant(ValueError):
    """An expression without value; the text gives the reason."""


def evaluate(node: Any, look_up: Callable[[Any], Value]) -> Value:
    """Return the value of an expression; `look_up` gives those of names.

    Raises:
        BadConstant: It has none.
    """
    if node.data == "scoped":
        return look_up(node)
    if node.data == "literal":
        return _literal([str(token) for token in node.children])
    parts = list(node.children)
    if node.data == "unary":
        sign, value = str(parts[0]), _number(evaluate(parts[1], look_up))
        if sign == "~":
            return ~_whole(value)
        return -value if sign == "-" else value
    if node.data in _FIXED:
        parts = _interleaved(parts, _FIXED[node.data])
    result = evaluate(parts[0], look_up)
    for sign, right in zip(parts[1::2], parts[2::2], strict=True):
        result = _combine(str(sign), _number(result), _number(evaluate(right, look_up)))
    return result


def _interleaved(parts: list[Any], sign: str) -> list[Any]:
    mixed = [parts[0]]
    for part in parts[1:]:
        mixed += [sign, part]
    return mixed


def _combine(sign: str, left: int | float, right: int | float) -> int | float:
    if sign in ("/", "%") and right == 0:
        raise BadConstant("division by zero")
    if sign not in ("+", "-", "*", "/"):
        left, right = _whole(left), _whole(right)
        if sign in ("<<", ">>") and not 0 <= right < _LARGEST_SHIFT:
            raise BadConstant(f"shift by {right}")
    found: int | float = _OPERATORS[sign](left, right)
    return found


def _divided(left: int | float, right: int | float) -> int | float:
    """Return the quotient, of integers cut towards zero."""
    if isinstance(left, int) and isinstance(right, int):
        quotient = abs(left) // abs(right)
        return quotient if (left < 0) == (right < 0) else -quotient
    return left / right


def _number(value: Value) -> int | float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise BadConstant(f"{value!r} is not a number")
    return value


def _whole(value: int | float) -> int:
    if not isinstance(value, int):
        raise BadConstant(f"{value} is not an integer")
    return value


def _literal(tokens: list[str]) -> Value:
    first = tokens[0]
    if first in ("TRUE", "FALSE"):
        return first == "TRUE"
    if first.removeprefix("L")[:1] in ("'", '"'):
        return "".join(_ESCAPE.sub(_unescaped, token.removeprefix("L")[1:-1]) for token in tokens)
    if first[:2] in ("0x", "0X"):
        return int(first, 16)
    digits = first.rstrip("dD")
    if digits != first or any(c in ".eE" for c in digits):
        return float(digits)
    if not digits.startswith("0"):
        return int(digits)
    if not _OCTAL.fullmatch(digits):
        raise BadConstant(f"{digits} is no octal number")
    return int(digits, 8)


def _unescaped(found: re.Match[str]) -> str:
    code = found[1]
    if code in _CHARACTERS:
        return _CHARACTERS[code]
    if code[0] in "xu":
        return chr(int(code[1:], 16))
    return chr(int(code, 8)) if code[0] in "01234567" else code
