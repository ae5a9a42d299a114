"""Conditions of a search on live properties: ``PROPERTY OP VALUE``, and near to a place."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from typing import Any, NamedTuple

from rtkit import PropertyError
from rtkit.services.misread import misread

_CONDITION = re.compile(
    r"""\s*([^\s<>=!~]+)\s*(<=|>=|!=|==|<|>|=|~)
    \s*("(?:[^"\\]|\\.)*"|'[^']*'|\([^()]*\)|[^\s<>=!~"'()][^\s"'()]*)(?:\s+and\s+(?=\S)|\s*$)""",
    re.VERBOSE,
)
_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
    "=": lambda value, wanted: _is_or_has(value, wanted),
    "==": lambda value, wanted: _is_or_has(value, wanted),
    "!=": lambda value, wanted: not _is_or_has(value, wanted),
    "~": lambda value, pattern: fnmatchcase(str(value), str(pattern)),
}  # fmt: skip


class LiveCondition(NamedTuple):
    """Condition on a property: ``level >= 0.5``."""

    name: str
    holds: Callable[[Any], bool]


def conditions(where: str) -> list[LiveCondition]:
    """Read conditions that are joined by ``and``.

    Raises:
        PropertyError: ``bad-parameter``; tells where it cannot be read.
    """
    made: list[LiveCondition] = []
    where, at = where.strip(), 0
    while at < len(where):
        match = _CONDITION.match(where, at)
        if match is None:
            why = misread(where, at, "expected PROPERTY OP VALUE [and …]")
            raise PropertyError("bad-parameter", why)
        made.append(_condition(match[1], match[2], _plain(match[3])))
        at = match.end()
    return made


def _condition(name: str, sign: str, wanted: Any) -> LiveCondition:
    def holds(value: Any) -> bool:
        try:
            return _COMPARE[sign](value, wanted)
        except TypeError:
            return False  # of another kind

    return LiveCondition(name, holds)


def _is_or_has(value: Any, wanted: Any) -> bool:
    is_among = isinstance(value, tuple) and not isinstance(wanted, tuple)
    return wanted in value if is_among else bool(value == wanted)


def near_to(near: Sequence[float]) -> LiveCondition:
    """Return the condition that a location is at most so far from a place: ``(x y z r)`` [m].

    Raises:
        PropertyError: ``bad-parameter``: it is something else.
    """
    if len(near) not in (3, 4):
        raise PropertyError("bad-parameter", "near: (x y r) or (x y z r)")
    *centre, radius = near

    def holds(value: Any) -> bool:
        is_place = isinstance(value, tuple) and len(value) >= len(centre)
        return is_place and math.dist(value[: len(centre)], centre) <= radius

    return LiveCondition("location", holds)


def _plain(text: str) -> Any:
    if text in ("true", "false"):
        return text == "true"
    if text.startswith("("):
        return tuple(map(_plain, text[1:-1].split()))
    if text[0] in "\"'":
        return re.sub(r"\\(.)", r"\1", text[1:-1])
    try:
        return float(text)
    except ValueError:
        return text
