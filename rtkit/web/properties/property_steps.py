"""Steps that set live properties, and what takes a SET back: the value that was before."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rtkit.errors import Refused
from rtkit.property.codes import PropertyError
from rtkit.property.reading import read
from rtkit.property.values import Element
from rtkit.web.fields import text_in
from rtkit.web.live.steps import Action, CommandStep

ValueOf = Callable[[str], "str | bytes"]
"""Returns the payload of a property, given its target; blocks."""
_WHY_NOT = {"write-only": "it cannot be read", "unknown": "there is no value of it"}


class Before(NamedTuple):
    """The value of a property before a SET.

    Attributes:
        text: The value; None where it is not known, or cannot be set again.
        why: Why a SET cannot be taken back; empty if it can.
    """

    text: str | None
    why: str = ""


def before_of(target: str, value_of: ValueOf) -> Before:
    """Return the value of a property that is about to be set."""
    try:
        found = value_of(target)
    except PropertyError as error:
        return Before(None, _WHY_NOT.get(error.code, "its value was not known"))
    if isinstance(found, bytes):
        return Before(None, "its value is bytes")
    if _does(found):
        return Before(None, "what it began is not ended by another value")
    return Before(found)


def _does(text: str) -> bool:
    """Return whether a value tells how an action or a behaviour stands: a SET begins one."""
    try:
        value = read(text)
    except PropertyError:
        return False
    return isinstance(value, Element) and "state" in value.attributes


def inverse(target: str, old: str, new: str) -> Action:
    """Return the action that takes a SET back, if the value is still what it has become."""
    return {"do": "set", "target": target, "value": old, "expect": new}


def set_value(action: Action, value_of: ValueOf) -> CommandStep:
    """Set a live property, as ``rtset`` does.

    Raises:
        Refused: It has another value than the action expects.
        PropertyError: It cannot be reached.
    """
    target, value = text_in(action, "target"), text_in(action, "value")
    old, why = before_of(target, value_of)
    if "expect" in action:
        expected = text_in(action, "expect")
        if old is None or not is_same(old, expected):
            now = why if old is None else f"it is {old}, not {expected}"
            raise Refused(f"{target} has been changed since: {now}")
    undo = None if old is None else (inverse(target, old, value),)
    line = ("rtset", "--", target, value)
    step = CommandStep(f"Set {target} to {value}", line, undo, why)
    return step._replace(target=target, old=old, new=value)


def is_same(one: str, other: str) -> bool:
    """Return whether two texts are the same value, as ``1`` and ``1.0`` are."""
    try:
        return one == other or read(one) == read(other)
    except PropertyError:
        return False
