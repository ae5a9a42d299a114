"""Narrows meta data to what may be set through a proxy, where the owner alone allows more.

No other module of a proxy reads the meta data of a property; no module reads its values.
"""

from __future__ import annotations

from collections.abc import Callable

from rtkit.property.codes import PropertyError
from rtkit.property.reading import read
from rtkit.property.values import Element, Value, Word
from rtkit.property.writing import write

_META, _ACCESS, _LISTED = ".meta", ".meta.access", "properties"

MaySet = Callable[[str], bool]


def describes_access(name: str, parameters: dict[str, str | None]) -> bool:
    """Return whether the answer to a GET describes the access to properties."""
    is_listing = name == _LISTED or name.endswith(f".{_LISTED}")
    return name.endswith((_META, _ACCESS)) or (is_listing and "meta" in parameters)


def narrowed(name: str, text: str, may_set: MaySet) -> str:
    """Return an answer of that kind with read-only access to what may not be set.

    Args:
        name: What was asked for.
        text: What the owner answered.
        may_set: Whether a property may be set, named as `name` is.
    """
    try:
        value = read(text)
    except PropertyError:
        return text  # an owner of another make: nothing in it is understood
    if name.endswith(_ACCESS):
        return text if may_set(name.removesuffix(_ACCESS)) else write(_without_w(value))
    if name.endswith(_META):
        return text if may_set(name.removesuffix(_META)) else write(_read_only(value))
    place = name.removesuffix(_LISTED)
    rows = value if isinstance(value, tuple) else ()
    return write(tuple(_row(each, place, may_set) for each in rows))


def _row(row: Value, place: str, may_set: MaySet) -> Value:
    """Return ``(name meta value)`` of a listing, narrowed."""
    if not isinstance(row, tuple) or len(row) < 2 or may_set(f"{place}{row[0]}"):
        return row
    return (row[0], _read_only(row[1]), *row[2:])


def _read_only(meta: Value) -> Value:
    if not isinstance(meta, Element):
        return meta
    children = tuple(
        Element(each.name, each.attributes, (), _without_w(each.leaf))
        if each.name == "access" and each.leaf is not None
        else each
        for each in meta.children
    )
    return Element(meta.name, meta.attributes, children, meta.leaf)


def _without_w(access: Value) -> Value:
    text = str(access)
    return Word(text.replace("w", "")) if "r" in text else access
