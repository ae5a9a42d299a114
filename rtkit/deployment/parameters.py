"""Whether a text fits a configuration parameter, by the hints that its component gives.

Components tell type, constraint and widget of a parameter in hidden sets, as RTC profiles do:
``__type__``, ``__constraints__`` and ``__widget__``. Where nothing is told anything fits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rtkit.errors import Malformed

TYPE_SET = "__type__"
CONSTRAINT_SET = "__constraints__"
WIDGET_SET = "__widget__"

_LIST_WIDGETS = ("checkbox", "ordered_list")
_INTEGERS = ("short", "int", "long", "longlong", "octet", "byte")
_NUMBERS = ("float", "double", "longdouble")
_TRUTHS = ("bool", "boolean")


def misfit(sets: Mapping[str, Mapping[str, str]], name: str, text: str) -> str:
    """Return why parameter `name` cannot be `text`; empty when it can."""
    base, is_vector = _type(_hint(sets, TYPE_SET, name))
    why = _wrong_type(base, is_vector, text)
    if why or base in _TRUTHS:
        return why  # a truth value has more spellings than a constraint would list
    rule = _hint(sets, CONSTRAINT_SET, name)
    is_list = is_vector or _hint(sets, WIDGET_SET, name).startswith(_LIST_WIDGETS)
    return f"it is to be {rule}" if rule and _violates(rule, text, is_list) else ""


def _hint(sets: Mapping[str, Mapping[str, str]], set_id: str, name: str) -> str:
    return sets.get(set_id, {}).get(name, "")


def _type(declared: str) -> tuple[str, bool]:
    """Return the plain name of a type, and whether it is a sequence of such."""
    bare = declared.replace(" ", "").lower().removeprefix("std::").removeprefix("unsigned")
    if bare.startswith("vector<") and bare.endswith(">"):
        return bare[len("vector<") : -1], True
    return bare.removesuffix("[]"), bare.endswith("[]")


def _wrong_type(base: str, is_vector: bool, text: str) -> str:
    from rtkit.component.kinds import elements, read_bool, read_float, read_int

    read: Callable[[str], object]
    if base in _INTEGERS:
        read, what = read_int, "integer"
    elif base in _NUMBERS:
        read, what = read_float, "number"
    elif base in _TRUTHS:
        read, what = read_bool, "truth value"
    else:
        return ""
    for part in elements(text) if is_vector else [text]:
        try:
            read(part)
        except Malformed:
            return f"{part!r} is no {what}" if is_vector else f"it is no {what}"
    return ""


def _violates(rule: str, text: str, is_list: bool) -> bool:
    from rtkit.component.kinds import elements
    from rtkit.profile.constraint_text import parse_constraint
    from rtkit.profile.constraint_value import allows

    try:
        constraint = parse_constraint(rule)
    except Malformed:
        return False  # words of the author, not a rule that a machine can read
    return constraint is not None and not allows(constraint, elements(text) if is_list else text)
