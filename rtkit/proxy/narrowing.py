"""Narrows meta data to what may be set through a proxy, where the owner alone allows more.

Widgets also get the names of this side. No other module of a proxy reads the meta data of a
property; no module reads its values.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rtkit.property.codes import PropertyError
from rtkit.property.reading import read
from rtkit.property.values import Element, Value, Word
from rtkit.property.writing import write

_META, _ACCESS, _LISTED = ".meta", ".meta.access", "properties"
GUI = "gui"
ROUND = "round"

MaySet = Callable[[str], bool]


def describes_access(name: str, parameters: dict[str, str | None]) -> bool:
    """Return whether the answer to a GET describes the access to properties."""
    is_listing = name == _LISTED or name.endswith(f".{_LISTED}")
    is_meta = name.endswith((_META, _ACCESS)) or (is_listing and "meta" in parameters)
    return is_meta or describes_widgets(name)


def describes_widgets(name: str) -> bool:
    """Return whether the answer to a GET is a ``<gui>``, with those of all that lies below."""
    return name == GUI or name.endswith(f".{GUI}")


def narrowed(
    name: str, text: str, may_set: MaySet, outward: Callable[[str], str] = lambda name: name
) -> str:
    """Return an answer of that kind with read-only access to what may not be set.

    Args:
        name: Name that was asked for.
        text: Answer of the owner.
        may_set: Whether a property may be set, named as `name` is.
        outward: Returns the name here of what the owner calls otherwise.
    """
    value = _read(text)
    if value is None:
        return text
    if name.endswith(_ACCESS):
        return text if may_set(name.removesuffix(_ACCESS)) else write(_without_w(value))
    if name.endswith(_META):
        return text if may_set(name.removesuffix(_META)) else write(_read_only(value))
    if describes_widgets(name):
        return write(_widget(value, outward, may_set))
    place = name.removesuffix(_LISTED)
    rows = value if isinstance(value, tuple) else ()
    return write(tuple(_row(each, place, may_set) for each in rows))


def joined(text: str, mounted: Mapping[str, str]) -> str:
    """Return the widgets of a service with those of its mounts, by name, in their places.

    Where there are none the widget of the mount point stays, and says why: ``ROUND`` where it leads
    back to a service whose widgets are among those, else its owner is away.
    """

    def whole(gui: Element) -> Element:
        name = gui.attributes.get("name", "") if "argument" not in gui.attributes else ""
        given = mounted.get(name)
        found = None if given is None else _read(given)
        if isinstance(found, Element):
            return found
        why = {} if given is None else {ROUND if given == ROUND else "away": "true"}
        return Element(gui.name, {**gui.attributes, **why}, tuple(map(whole, gui.children)))

    own = _read(text)
    return write(whole(own)) if isinstance(own, Element) else text


def _read(text: str) -> Value | None:
    """Return a value; None from an owner of another make: nothing in it is understood."""
    try:
        return read(text)
    except PropertyError:
        return None


def _widget(gui: Value, outward: Callable[[str], str], may_set: MaySet) -> Value:
    """Return a ``<gui>`` with the names and the access of this side; arguments have bare keys."""
    if not isinstance(gui, Element) or "argument" in gui.attributes:
        return gui
    given = dict(gui.attributes)
    if "name" in given:
        given["name"] = outward(given["name"])
        given |= {"access": "r"} if "access" in given and not may_set(given["name"]) else {}
    children = tuple(_widget(each, outward, may_set) for each in gui.children)
    return Element(gui.name, given, children, gui.leaf)  # type: ignore[arg-type]


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
