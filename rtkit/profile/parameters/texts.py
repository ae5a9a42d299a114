"""Reads ``${name}`` in the texts of a profile, and conditions; nothing is evaluated as code."""

from __future__ import annotations

import re
from collections.abc import Mapping

from rtkit.errors import Malformed
from rtkit.rtc.nearest import did_you_mean

NAME = r"[A-Za-z_][A-Za-z0-9_-]*"
PREFIX = r"[\w.-]*"
"""Texts that names may begin with: nothing that has a meaning in paths."""

MOST_TEXT = 1 << 16
"""Values that a text holds are not longer together: variables made of others grow fast."""

_REFERENCE = re.compile(r"\$\$|\$\{([^}]*)(\}?)")
_COMPARISON = re.compile(r"(.*?)(==|!=)(.*)", re.DOTALL)
_TRUE, _FALSE = ("true", "yes", "on", "1"), ("false", "no", "off", "0")


def substituted(text: str, values: Mapping[str, str]) -> str:
    """Return a text with the values of its variables; ``$$`` stands for one dollar.

    >>> substituted("${side}_arm costs $$5", {"side": "left"})
    'left_arm costs $5'

    Raises:
        Malformed: There is no such variable, a brace is not closed, or it becomes too long.
    """
    room = MOST_TEXT

    def value(found: re.Match[str]) -> str:
        nonlocal room
        if found[0] == "$$":
            return "$"
        name = found[1]
        if not found[2]:
            raise Malformed(f"{found[0]} has no closing brace; $$ stands for a dollar")
        if name not in values:
            raise Malformed(_unknown(name, values))
        room -= len(values[name])
        if room < 0:
            raise Malformed(f"becomes longer than {MOST_TEXT} characters")
        return values[name]

    return _REFERENCE.sub(value, text)


def _unknown(name: str, values: Mapping[str, str]) -> str:
    known, dash, _ = name.partition(":-")
    if dash and known in values:
        return f"${{{name}}}: the default of {known} stands where the variable is declared"
    hint = did_you_mean(name, values)
    declared = hint or f'; declare it: <rtkit:Variable rtkit:name="{known}"/>'
    return f"no variable {known}{declared}"


def holds(condition: str, values: Mapping[str, str]) -> bool:
    """Return whether a condition holds: ``A == B``, ``A != B``, or a boolean.

    Both sides are texts, perhaps in quotes, and compared as such.

    >>> holds("${side} == left", {"side": "left"}), holds("${camera}", {"camera": "no"})
    (True, False)

    Raises:
        Malformed: It is neither, or names an unknown variable.
    """
    compared = _COMPARISON.fullmatch(condition)
    if compared is None:
        word = _operand(condition, values).lower()
        if word not in _TRUE + _FALSE:
            raise Malformed(
                f"{condition!r} is {word!r}, neither true nor false; A == B and A != B compare"
            )
        return word in _TRUE
    left, operator, right = compared.groups()
    return (_operand(left, values) == _operand(right, values)) == (operator == "==")


def _operand(text: str, values: Mapping[str, str]) -> str:
    text = text.strip()
    is_quoted = len(text) > 1 and text[0] == text[-1] and text[0] in "'\""
    return substituted(text[1:-1] if is_quoted else text, values)
