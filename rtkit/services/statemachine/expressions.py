"""Conditions and values of state machines: reads a small grammar and computes it, without `eval`.

``robots/r1.location.x > 1 and not (light.on or variables.laps >= 3)``. A name with a dot or a slash
is a property of a service, ``variables.laps`` a variable of the machine, any other name a text.
Signs that a name may contain (``-``, ``+``, ``/``) have blanks around them. An unknown value makes
a comparison unknown, which is not true.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from math import inf
from typing import Any

from rtkit.services.misread import misread

Plain = bool | int | float | str
Look = Callable[[str], Any]
"""Returns the value of a property or variable, None while it is not known."""

VARIABLES = "variables."
_MOST_TOKENS = 200
_DEEPEST = 50
_EXACT = 2**53
_TOKEN = re.compile(
    r"""\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<text>"(?:[^"\\]|\\.)*")
    |(?P<name>/?[A-Za-z_](?:[\w~%:+-]|[./](?=[\w~%]))*(?:\?[^\s()<>]*)?)
    |(?P<sign><=|>=|!=|==|[<>=()+*/-]))""",
    re.VERBOSE | re.ASCII,
)
_COMPARISONS = ("<", "<=", ">", ">=", "=", "!=")
_LEVELS = (("or",), ("and",), _COMPARISONS, ("+", "-"), ("*", "/"))
_COMPARED = 2
_ESCAPED = re.compile(r"\\(.)")
_CONTROLS = {"n": "\n", "r": "\r", "t": "\t"}


class Expression:
    """Condition or value, read once.

    Attributes:
        text: As it was written.
        names: The properties that it reads.
        variables: The variables that it reads.

    Raises:
        ValueError: It cannot be read; tells where.
    """

    def __init__(self, text: str) -> None:
        reader = _Reader(text)
        self.text = text
        self._tree = reader.tree()
        own = {each for each in reader.names if each.startswith(VARIABLES)}
        self.variables = frozenset(each.removeprefix(VARIABLES) for each in own)
        self.names = frozenset(reader.names - own)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expression) and other.text == self.text

    def __hash__(self) -> int:
        return hash(self.text)

    def value(self, look: Look) -> Plain | None:
        """Return what it comes to, None while something in it is not known or does not fit."""
        return _value(self._tree, look)

    def is_true(self, look: Look) -> bool:
        """Return whether it is known to be true."""
        return self.value(look) is True


class _Reader:
    def __init__(self, text: str) -> None:
        self._text = text
        self.names: set[str] = set()
        self._tokens: list[tuple[str, str, int]] = []
        position, end = 0, len(text.rstrip())
        while position < end:
            found = _TOKEN.match(text, position)
            if found is None or len(self._tokens) == _MOST_TOKENS:
                raise ValueError(misread(text, position, "too long" if found else "cannot be read"))
            kind = found.lastgroup or ""
            self._tokens.append((kind, found[kind], found.start(kind)))
            position = found.end()
        self._tokens.append(("end", "", end))
        self._at = self._depth = 0

    def tree(self) -> tuple[Any, ...]:
        tree = self._binary(0)
        if self._tokens[self._at][0] != "end":
            raise self._unexpected()
        return tree

    def _unexpected(self) -> ValueError:
        _, text, position = self._tokens[self._at]
        return ValueError(misread(self._text, position, f"did not expect {text or 'the end'}"))

    def _taken(self, *wanted: str) -> str:
        kind, text, _ = self._tokens[self._at]
        sign = "=" if text == "==" else text
        if kind not in ("sign", "name") or sign not in wanted:
            return ""
        self._at += 1
        return sign

    def _binary(self, level: int) -> tuple[Any, ...]:
        if level == len(_LEVELS):
            return self._single()
        if level == _COMPARED and self._taken("not"):
            return ("not", self._binary(level))
        left = self._binary(level + 1)
        while sign := self._taken(*_LEVELS[level]):
            left = (sign, left, self._binary(level + 1))
            if level == _COMPARED:
                break  # a < b < c is none
        return left

    def _single(self) -> tuple[Any, ...]:
        if self._taken("-"):
            return ("-", ("is", 0), self._single())
        if self._taken("("):
            self._depth += 1
            if self._depth > _DEEPEST:
                why = f"more than {_DEEPEST} brackets inside each other"
                raise ValueError(misread(self._text, self._tokens[self._at][2], why))
            inside = self._binary(0)
            self._depth -= 1
            if not self._taken(")"):
                raise self._unexpected()
            return inside
        kind, text, _ = self._tokens[self._at]
        if kind in ("end", "sign") or text in ("and", "or", "not"):
            raise self._unexpected()
        self._at += 1
        if kind == "text":
            return ("is", _ESCAPED.sub(lambda found: _CONTROLS.get(found[1], found[1]), text[1:-1]))
        if kind == "name" and ("." in text or "/" in text):
            self.names.add(text)
            return ("name", text)
        return ("is", plain_of(text))


def plain_of(text: str) -> Plain:
    """Return the number or truth that a text says, else the text."""
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        try:
            return kind(text) if "_" not in text else text
        except ValueError:
            continue
    return text


def written(value: Plain) -> str:
    """Return a value as a SET carries it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if not isinstance(value, str):
        return repr(value)
    is_word = re.fullmatch(r"[A-Za-z_][\w.-]*", value, re.ASCII) and plain_of(value) == value
    if is_word and value not in ("inf", "nan", "true", "false"):
        return value
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    for letter, control in _CONTROLS.items():
        escaped = escaped.replace(control, f"\\{letter}")
    return f'"{escaped}"'


def _value(tree: tuple[Any, ...], look: Look) -> Plain | None:
    """Compute a tree; it is at most as deep as its text has tokens."""
    sign, *parts = tree
    if sign == "is":
        constant: Plain = parts[0]
        return constant
    if sign == "name":
        value = look(parts[0])
        return value if isinstance(value, Plain) else None
    values = [_value(each, look) for each in parts]
    if sign in ("and", "or", "not"):
        return _truth(sign, [each if isinstance(each, bool) else None for each in values])
    left, right = values
    if left is None or right is None:
        return None
    return _compared(sign, left, right) if sign in _COMPARISONS else _computed(sign, left, right)


def _truth(sign: str, values: list[bool | None]) -> bool | None:
    if sign == "not":
        return None if values[0] is None else not values[0]
    decides = sign == "or"
    return decides if decides in values else None if None in values else not decides


def _is_number(value: Plain) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _compared(sign: str, left: Any, right: Any) -> bool | None:
    is_alike = _is_number(left) == _is_number(right) and isinstance(left, str) == isinstance(
        right, str
    )
    if sign in ("=", "!="):
        return (is_alike and left == right) == (sign == "=")
    if not is_alike or isinstance(left, bool):
        return None
    low, high = (left, right) if sign[0] == "<" else (right, left)
    return bool(low < high or (sign[1:] == "=" and low == high))


def _computed(sign: str, left: Any, right: Any) -> Plain | None:
    if not (_is_number(left) and _is_number(right)) or (sign == "/" and right == 0):
        return None
    left, right = _exact(left), _exact(right)
    if sign == "/":
        return float(left / right)
    result = left + right if sign == "+" else left - right if sign == "-" else left * right
    return _exact(result)


def _exact(number: float) -> float:
    """Return a number as a float where it is a whole one that floats do not have all of."""
    if isinstance(number, float) or abs(number) <= _EXACT:
        return number
    try:
        return float(number)
    except OverflowError:
        return inf if number > 0 else -inf
