"""Between objects of Python and values of properties.

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


def to_value(thing: object, depth: int = 0) -> Content:
    """Return the value that stands for an object; None is the empty group.

    Raises:
        PropertyError: ``too-large``: it holds itself, or is nested too deep.
    """
    if isinstance(thing, Enum):
        return Word(thing.name)
    if thing is None:
        return ()
    if isinstance(thing, bool | Word | Element):
        return thing
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
        children = [Element(name, {}, (), _item(getattr(thing, name), depth)) for name in fields]
        return Element(type(thing).__name__.lower(), {}, tuple(children))
    if _has_text(thing):
        return str(thing)
    return Element("object", {"type": type(thing).__name__})


def _has_text(thing: object) -> bool:
    """Whether the text of an object says more than where it lies in memory."""
    cls = type(thing)
    is_told = any("__str__" in vars(base) for base in cls.__mro__ if base is not object)
    return is_told or cls.__module__ == "builtins"


def _item(thing: object, depth: int) -> Value:
    value = to_value(thing, depth + 1)
    return Element("bytes", {"length": str(len(value))}) if isinstance(value, bytes) else value


def is_array(thing: object) -> bool:
    """Whether something is an array or a number of numpy."""
    module = type(thing).__module__
    return module.partition(".")[0] == "numpy" and hasattr(thing, "tolist")


def from_value(value: Content, hint: Any, present: object) -> Any:
    """Return the object that a value stands for, like the annotation or what is there now.

    Raises:
        PropertyError: ``bad-value``: none of them fits.
    """
    if isinstance(hint, type) and issubclass(hint, Enum):
        return _member(hint, value)
    if hint is None and isinstance(present, Enum):
        return _member(type(present), value)
    if is_array(present):
        return _array(present, value)
    if hint is float and isinstance(value, int):
        return float(value)
    if isinstance(value, tuple):
        return _sequence(value, present)
    return str(value) if isinstance(value, Word) else value


def _member(kind: type[Enum], value: Content) -> Enum:
    for member in kind:
        if isinstance(value, str) and member.name == str(value):
            return member
    told = " ".join(member.name for member in kind)
    raise PropertyError("bad-value", f"expected one of {told}")


def _array(present: Any, value: Content) -> Any:
    from importlib import import_module

    made = import_module("numpy").asarray(_plain(value), dtype=present.dtype)
    shape = getattr(present, "shape", ())
    if made.shape != shape:
        raise PropertyError("bad-value", f"expected the shape {shape}, found {made.shape}")
    return made if shape else made[()]


def _sequence(value: tuple[Value, ...], present: object) -> Any:
    if not value and present is None:
        return None
    plain = _plain(value)
    if isinstance(present, dict):
        if not all(isinstance(pair, list) and len(pair) == 2 for pair in plain):
            raise PropertyError("bad-value", "expected a list of (name value)")
        return {pair[0]: pair[1] for pair in plain}
    for kind in (tuple, set, frozenset):
        if isinstance(present, kind):
            return kind(plain)
    return plain


def _plain(value: Content) -> Any:
    """Return nested lists and plain texts for a value; elements stay what they are."""
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    return str(value) if isinstance(value, Word) else value
