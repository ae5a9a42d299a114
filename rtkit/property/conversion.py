"""Converts between Python objects and values of properties.

numpy is known where somebody has imported it: its arrays become vectors or lists of them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence, Set
from enum import Enum
from typing import Any

from rtkit.property.codes import PropertyError
from rtkit.property.types import Content
from rtkit.property.values import Element, Value, Word

_DEEPEST = 32
_AS_THEY_ARE = frozenset({float, int, str, bool, bytes, Word, Element})
_OWN = "rtkit.property.marker"


def to_value(thing: object, depth: int = 0) -> Content:
    """Return the value that stands for an object; None is the empty group.

    Raises:
        PropertyError: ``too-large``: it holds itself, or is nested too deep.
    """
    if type(thing) in _AS_THEY_ARE:
        return thing  # type: ignore[return-value]
    if isinstance(thing, Enum):
        return Word(thing.name)
    if thing is None:
        return ()
    if isinstance(thing, Word | Element):
        return thing
    if has_element(thing):
        return thing.__element__()  # type: ignore[attr-defined,no-any-return]
    if isinstance(thing, int):
        return int(thing)
    if isinstance(thing, float):
        return float(thing)
    if isinstance(thing, str):
        return str(thing)
    if isinstance(thing, bytes | bytearray):
        return bytes(thing)
    if depth > _DEEPEST:
        raise PropertyError("too-large", f"nested deeper than {_DEEPEST}")
    return _composed(thing, depth)


def _composed(thing: Any, depth: int) -> Content:
    if type(thing) in (tuple, list):
        return tuple([_item(each, depth) for each in thing])
    if is_array(thing):
        return to_value(thing.tolist(), depth + 1)
    if isinstance(thing, Mapping):
        return tuple((_item(key, depth), _item(each, depth)) for key, each in thing.items())
    if isinstance(thing, Sequence):
        return tuple(_item(each, depth) for each in thing)
    if isinstance(thing, Set):
        return tuple(sorted((_item(each, depth) for each in thing), key=repr))
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        fields = [each.name for each in dataclasses.fields(thing) if not each.name.startswith("_")]
        children = [child_of(name, _item(getattr(thing, name), depth)) for name in fields]
        return Element(type(thing).__name__.lower(), {}, tuple(children))
    if _has_text(thing):
        return str(thing)
    return Element("object", {"type": type(thing).__name__})


def child_of(name: str, value: Value) -> Element:
    """Return an element that holds a value: elements as its children, all else as its leaf."""
    items = value if isinstance(value, tuple) else (value,)
    elements = tuple(each for each in items if isinstance(each, Element))
    if elements and len(elements) == len(items):
        return Element(name, {}, elements)
    return Element(name, {}, (), value)


def _has_text(thing: object) -> bool:
    """Return whether the text of an object says more than where it lies in memory."""
    cls = type(thing)
    has_own_text = any("__str__" in vars(base) for base in cls.__mro__ if base is not object)
    return has_own_text or cls.__module__ == "builtins"


def _item(thing: object, depth: int) -> Value:
    value = to_value(thing, depth + 1)
    return Element("bytes", {"length": str(len(value))}) if isinstance(value, bytes) else value


def has_element(thing: object) -> bool:
    """Return whether an object, or a class, says itself which element stands for it."""
    return hasattr(thing if isinstance(thing, type) else type(thing), "__element__")


def is_array(thing: object) -> bool:
    """Return whether something is an array or a number of numpy."""
    module = type(thing).__module__
    return module.partition(".")[0] == "numpy" and hasattr(thing, "tolist")


_BUILTIN = frozenset({int, float, bool, str, bytes, bytearray, type(None), Word, Element})


def is_builtin(thing: object) -> bool:
    """Return whether no code of a user is called to make a value of an object."""
    kind = type(thing)
    if kind in _BUILTIN or isinstance(thing, Enum) or kind.__module__ == _OWN:
        return True
    if kind in (list, tuple, set, frozenset):
        return all(map(is_builtin, thing))  # type: ignore[call-overload]
    if kind is dict:
        return all(is_builtin(key) and is_builtin(each) for key, each in thing.items())  # type: ignore[attr-defined]
    return is_array(thing) and getattr(getattr(thing, "dtype", None), "kind", "O") != "O"
