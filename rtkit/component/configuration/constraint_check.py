"""Checks texts against the declared type and constraint of a configuration parameter.

RTC profiles declare types and constraints. Components publish them in hidden sets: ``__type__``,
``__constraints__`` and ``__widget__``. Without a declaration every text fits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from rtkit.errors import Malformed
from rtkit.rtc.nearest import did_you_mean

if TYPE_CHECKING:
    from rtkit.profile.constraint_model import Constraint

TYPE_SET = "__type__"
CONSTRAINT_SET = "__constraints__"
WIDGET_SET = "__widget__"
DESCRIPTION = "description"
"""The parameter of a set that tells what the set is for."""
_DEFAULT_SET = "default"

_LIST_WIDGETS = ("checkbox", "ordered_list")
_INTEGERS = ("short", "int", "long", "longlong", "octet", "byte")
_NUMBERS = ("float", "double", "longdouble")
_TRUTHS = ("bool", "boolean")


class Declared(NamedTuple):
    """The declared type and constraint of a parameter.

    Attributes:
        type: Its type, in the free words of profiles.
        rule: Its constraint in one line, as it is shown.
        constraint: The same, as far as a machine can read it.
        is_list: It may have several values, whatever its type says.
    """

    type: str = ""
    rule: str = ""
    constraint: Constraint | None = None
    is_list: bool = False


def misfit(sets: Mapping[str, Mapping[str, str]], name: str, text: str) -> str:
    """Return why parameter `name` cannot be `text`, by the hints in these sets; empty if it can."""
    declared = hinted(sets, name)
    return misfit_of(declared, text) if declared.type or declared.rule else ""


def misfits(sets: Mapping[str, Mapping[str, str]], values: Iterable[tuple[str, str]]) -> str:
    """Return the misfits among several values in one line; empty when all fit."""
    whys = ((name, text, misfit(sets, name, text)) for name, text in values)
    return "; ".join(f"{name} cannot be {text!r}: {why}" for name, text, why in whys if why)


def parameter_names(sets: Mapping[str, Mapping[str, str]]) -> frozenset[str]:
    """Return what an added set of a component with these sets may hold.

    Hidden sets have hints, not parameters; each set may have a description.
    """
    visible = (values for set_id, values in sets.items() if not set_id.startswith("__"))
    return frozenset(name for values in visible for name in values) | {DESCRIPTION}


def no_parameter(name: str, known: Iterable[str], path: str) -> str:
    """Return the message that the component of a path has no parameter of that name."""
    return f"No such configuration parameter: {name} (on {path}){did_you_mean(name, known)}"


def hinted(sets: Mapping[str, Mapping[str, str]], name: str) -> Declared:
    """Return the declaration of a parameter in the hidden sets of a component."""
    rule = _hint(sets, CONSTRAINT_SET, name)
    is_list = _hint(sets, WIDGET_SET, name).startswith(_LIST_WIDGETS)
    type = declared_type(_hint(sets, TYPE_SET, name), _hint(sets, _DEFAULT_SET, name))
    return Declared(type, rule, read_constraint(rule), is_list)


def declared_type(type: str, default: str) -> str:
    """Return the type of a parameter: of a number whose default is a list, a vector of such."""
    base, is_vector, _ = _type(type)
    is_list = "," in default and base in (*_INTEGERS, *_NUMBERS) and not is_vector
    return f"vector<{type}>" if is_list else type


def _hint(sets: Mapping[str, Mapping[str, str]], set_id: str, name: str) -> str:
    return sets.get(set_id, {}).get(name, "")


def read_constraint(rule: str) -> Constraint | None:
    """Return a constraint as far as a machine can read it."""
    if not rule:
        return None
    from rtkit.profile.constraint_text import parse_constraint

    try:
        return parse_constraint(rule)
    except Malformed:
        return None  # words of the author, not a rule that a machine can read


def misfit_of(declared: Declared, text: str) -> str:
    """Return why a parameter declared so cannot be `text`; empty when it can."""
    base, is_vector, is_unsigned = _type(declared.type)
    parts = _elements(text) if is_vector else [text]
    why = _wrong_type(base, is_unsigned, parts, is_vector=is_vector)
    if why or base in _TRUTHS or declared.constraint is None:
        return why  # a truth value has more spellings than a constraint would list
    if not declared.type and _is_remark(declared.constraint):
        return ""
    from rtkit.profile.constraint_value import allows, broken_sentence

    value = _elements(text) if is_vector or declared.is_list else text
    wants_number = base in _INTEGERS or base in _NUMBERS
    if allows(declared.constraint, value, wants_number=wants_number):
        return ""
    return broken_sentence(declared.constraint, value) or f"it is to be {declared.rule}"


def _elements(text: str) -> list[str]:
    from rtkit.component.configuration.kinds import elements

    return elements(text)


def _type(declared: str) -> tuple[str, bool, bool]:
    """Return the plain name of a type, whether it is a sequence of such, whether unsigned."""
    bare = declared.replace(" ", "").lower().removeprefix("std::")
    is_vector = bare.endswith("[]")
    if bare.startswith("vector<") and bare.endswith(">"):
        bare, is_vector = bare[len("vector<") : -1].removeprefix("std::"), True
    bare = bare.removesuffix("[]")
    plain = bare.removeprefix("unsigned")
    return (plain or "int") if plain != bare else bare, is_vector, plain != bare


def _wrong_type(base: str, is_unsigned: bool, parts: list[str], *, is_vector: bool) -> str:
    from rtkit.component.configuration.kinds import read_bool, read_float, read_int

    read: Callable[[str], object]
    if base in _INTEGERS:
        read, what = read_int, "integer"
    elif base in _NUMBERS:
        read, what = read_float, "number"
    elif base in _TRUTHS:
        read, what = read_bool, "truth value"
    else:
        return ""
    for part in parts:
        try:
            value = read(part)
        except Malformed:
            return f"{part!r} is no {what}" if is_vector else f"it is no {what}"
        if is_unsigned and isinstance(value, int | float) and value < 0:
            return f"{part!r} is negative" if is_vector else "it is negative"
    return ""


def _is_remark(constraint: Constraint) -> bool:
    """Return whether a constraint is one bare word, where no type says that values are words.

    A parameter with one possible value is none: such a word is a comment of its author.
    """
    from rtkit.profile.constraint_model import Comparison, ConstraintUnit

    unit = constraint.content
    test = unit.test if isinstance(unit, ConstraintUnit) else None
    if not isinstance(test, Comparison) or test.kind != "propertyIsEqualTo":
        return False
    try:
        float(test.literal)
    except ValueError:
        return True
    return False
