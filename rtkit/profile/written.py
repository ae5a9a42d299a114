"""Shared parts of all profile writers: the order of parts, the text of values, its limits."""

from __future__ import annotations

import re
from typing import Any

from rtkit.errors import Malformed
from rtkit.profile.spec import FLAG, REAL, WHOLE, Attr, Child, ElementSpec, is_real, is_whole
from rtkit.profile.xmlnames import short, split
from rtkit.xmltext import bad_character

_LOCAL_NAME = r"[^\W\d][\w.-]*"


def check_text(text: str) -> str:
    """Return `text` if XML can carry it.

    Raises:
        Malformed: It has a character that XML cannot carry.
    """
    bad = bad_character(text)
    if bad:
        around = text[max(0, bad.start() - 20) : bad.start()]
        raise Malformed(f"character {bad[0]!r} after {around!r} cannot be written to XML")
    return text


def checked_name(name: str) -> str:
    """Return ``{namespace}local`` if XML can have such a name.

    Raises:
        Malformed: It cannot.
    """
    local = split(name)[1]
    if not re.fullmatch(_LOCAL_NAME, local):
        raise Malformed(f"{local!r} is not an XML name")
    return check_text(name)


def in_order(spec: ElementSpec, value: Any) -> tuple[Child, ...]:
    """Return the children to write; of the alternatives of one field, the one that fits."""
    return tuple(child for child in spec.children if _fits(child, value))


def _fits(child: Child, value: Any) -> bool:
    tag_field = child.spec.tag_field if child.spec is not None else None
    if tag_field is None:
        return True
    return bool(getattr(getattr(value, child.field), tag_field) == split(child.name)[1])


def format_value(item: Attr, value: Any) -> str:
    """Return the text of an attribute's value.

    Raises:
        Malformed: It is a number that no reader would take.
    """
    if item.kind == FLAG:
        return "true" if value else "false"
    if item.kind == REAL:
        text = repr(float(value))
        if not is_real(text):
            raise Malformed(f"{short(item.name)} must be a finite number, not {text}")
        return text
    if item.kind == WHOLE:
        text = str(int(value))
        if not is_whole(text):
            raise Malformed(f"{short(item.name)} is beyond 18 digits: {text}")
        return text
    return str(value)
