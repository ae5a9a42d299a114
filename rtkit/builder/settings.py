"""Converts configuration parameters of a profile; their defaults become Python values."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from rtkit.builder.identifiers import Taken, attribute_name, cut
from rtkit.builder.source_text import doc_text, one_line
from rtkit.builder.subject import GeneratedParameter
from rtkit.component.configuration.kinds import elements, read_bool, read_float, read_int
from rtkit.component.configuration.parameter import Parameter
from rtkit.errors import Malformed
from rtkit.profile.constraint_text import format_constraint
from rtkit.profile.rtc_model import ConfigurationParameter, RtcProfile
from rtkit.profile.words import property_value, values_in_sets

WIDGET = "__widget__"
_INTEGER = re.compile(r"(unsigned |signed )?(u?int\d*(_t)?|short|long|long long|char|byte|integer)")
_VECTOR = re.compile(r"(?:vector|sequence|list|array)?\s*<\s*(.+?)\s*(?:,.*)?>|(.+?)\s*\[\s*\]")
_REAL = ("double", "float", "real", "long double")
_MOST_DIGITS = 60
_Note = Callable[[str], None]


def settings_of(profile: RtcProfile, taken: Taken, note: _Note) -> tuple[GeneratedParameter, ...]:
    """Return the parameters; calls `note` with each fact that cannot be taken over as it is."""
    if profile.configuration_set is None:
        return ()
    names: set[str] = set()
    found = []
    for each in profile.configuration_set.configurations:
        name = unused(each.name or "parameter", names)
        if name != each.name:
            why = "its name is taken" if each.name else "it has no name"
            note(f"configuration parameter {each.name!r} is called {name}: {why}")
        attribute = taken.add(attribute_name(name, "parameter"))
        for text in cut("configuration parameter", name, attribute):
            note(text)
        found.append(_setting(each, name, attribute, note))
    return tuple(found)


def unused(name: str, names: set[str], link: str = "_") -> str:
    """Return a name like this one that is not among `names`, and add it."""
    free, number = name, 1
    while free in names:
        number += 1
        free = f"{name}{link}{number}"
    names.add(free)
    return free


def _setting(
    each: ConfigurationParameter, name: str, attribute: str, note: _Note
) -> GeneratedParameter:
    default = default_value(each.type, each.default_value, f"parameter {name}", note)
    constraint = _constraint(each, name, note)
    return GeneratedParameter(
        attribute=attribute,
        name=name,
        default=default,
        unit=one_line(each.unit or doc_text(each.doc, "unit")),
        doc=one_line(doc_text(each.doc, "description") or each.comment),
        constraint=constraint,
        widget=property_value(each.properties, WIDGET) or "",
        sets=_sets(each, name, default, constraint, note),
    )


def _sets(
    each: ConfigurationParameter, name: str, default: Any, constraint: str, note: _Note
) -> dict[str, Any]:
    """Return the values in further sets; those that the class would refuse are left out."""
    found = {}
    for set_id, text in values_in_sets(each.properties).items():
        value = default_value(each.type, text, f"parameter {name}", note)
        try:
            Parameter(default, name=name, constraint=constraint, sets={set_id: value})
        except Malformed as error:
            note(f"{error}; left out")
        else:
            found[set_id] = value
    return found


def _constraint(each: ConfigurationParameter, name: str, note: _Note) -> str:
    if each.constraint is None:
        return ""
    try:
        return format_constraint(each.constraint)
    except Malformed as error:
        note(f"parameter {name}: {error}; left out")
        return ""


def default_value(type: str, text: str, where: str, note: _Note) -> Any:
    """Return the default of a parameter; a text where it is no value of its type."""
    kind = " ".join(type.lower().replace("std::", "").split())
    vector = _VECTOR.fullmatch(kind)
    if vector:
        return _items((vector[1] or vector[2]).strip(), text, where, note)
    read = _reader(kind)
    if read is None:
        return text
    if not text.strip():
        note(f"{where}: no default for type {type}; it is {_ZEROS[read]!r}")
        return _ZEROS[read]
    try:
        return _number(read(text), text)
    except Malformed as error:
        if "," in text and read is not read_bool:
            return _items(kind, text, where, note)
        note(f"{where}: default {error}; it is a text")
        return text


_ZEROS: dict[Callable[[str], Any], bool | int | float] = {
    read_bool: False,
    read_int: 0,
    read_float: 0.0,
}


def _reader(kind: str) -> Callable[[str], Any] | None:
    if kind in _REAL:
        return read_float
    if kind in ("bool", "boolean"):
        return read_bool
    return read_int if _INTEGER.fullmatch(kind) and kind != "char" else None


def _items(kind: str, text: str, where: str, note: _Note) -> Any:
    read = _reader(kind)
    if read not in (read_int, read_float) or read is None:
        return text
    try:
        found = tuple(_number(read(item), item) for item in elements(text))
    except Malformed as error:
        note(f"{where}: default {error}; it is a text")
        return text
    return found if found or not text.strip() else text


def _number(value: Any, text: str) -> Any:
    if isinstance(value, int) and len(text.strip()) > _MOST_DIGITS:
        raise Malformed(f"too long: {text!r}")
    return value
