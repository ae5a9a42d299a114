"""Kinds of configuration parameters: reads their values from text and writes them as text."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, NamedTuple

from rtkit.errors import Malformed

Value = bool | int | float | str | tuple[float, ...] | tuple[int, ...]

_TRUE = ("true", "yes", "on", "1")
_FALSE = ("false", "no", "off", "0")
_INTEGER = r"[+-]?[0-9]{1,400}"
_BRACKETS = {"(": ")", "[": "]", "{": "}"}


class ParameterKind(NamedTuple):
    """Reader and writer of the values of one kind as text."""

    name: str
    read: Callable[[str], Any]
    write: Callable[[Any], str]


def read_bool(text: str) -> bool:
    """Read ``true yes on 1`` or ``false no off 0``, in any case.

    Raises:
        Malformed: Neither.
    """
    word = text.strip().lower()
    if word in _TRUE:
        return True
    if word in _FALSE:
        return False
    raise Malformed(f"not a truth value: {text!r}")


def read_int(text: str) -> int:
    """Read a decimal integer.

    Raises:
        Malformed: Anything else.
    """
    if not re.fullmatch(_INTEGER, text.strip()):
        raise Malformed(f"not an integer: {text!r}")
    return int(text)


def read_float(text: str) -> float:
    """Read a decimal number, ``inf`` or ``nan``.

    Raises:
        Malformed: Anything else.
    """
    try:
        if "_" in text or not text.isascii():
            raise ValueError
        return float(text)
    except ValueError:
        raise Malformed(f"not a number: {text!r}") from None


def read_text(text: str) -> str:
    """Return the text as it is."""
    return text


def elements(text: str) -> list[str]:
    """Return the texts of a vector's elements: commas or blanks between, brackets or none."""
    inner = text.strip()
    if inner and _BRACKETS.get(inner[0]) == inner[-1:]:
        inner = inner[1:-1].strip()
    return inner.split("," if "," in inner else None)


def _vector(item: Callable[[str], Any]) -> Callable[[str], tuple[Any, ...]]:
    return lambda text: tuple(map(item, elements(text)))


def _write_bool(value: bool) -> str:
    return "true" if value else "false"


def _write_vector(value: tuple[float, ...]) -> str:
    return ",".join(repr(item) for item in value)


_KINDS = {
    bool: ParameterKind("bool", read_bool, _write_bool),
    int: ParameterKind("int", read_int, str),
    float: ParameterKind("double", read_float, repr),
    str: ParameterKind("string", read_text, str),
}
_INTEGERS = ParameterKind("vector<int>", _vector(read_int), _write_vector)
_NUMBERS = ParameterKind("vector<double>", _vector(read_float), _write_vector)


def kind_of(default: Value) -> ParameterKind:
    """Return the kind of a parameter by its default value.

    Raises:
        Malformed: A value of a type that a parameter cannot have.
    """
    known = _KINDS.get(type(default))
    if known is not None:
        return known
    if isinstance(default, tuple) and all(type(item) in (int, float) for item in default):
        whole = bool(default) and all(type(item) is int for item in default)
        return _INTEGERS if whole else _NUMBERS
    raise Malformed(f"a configuration parameter cannot be a {type(default).__name__}: {default!r}")
