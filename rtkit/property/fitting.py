"""Builds Python objects from values after an annotation or the present object, or refuses.

numpy is known where somebody has imported it.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from enum import Enum
from typing import Any, get_args, get_origin

from rtkit.property.annotations import bare, hints_of, spec_of, type_of
from rtkit.property.codes import PropertyError
from rtkit.property.conversion import has_element, is_array, to_value
from rtkit.property.types import Content, check
from rtkit.property.values import Element, Value, Word, is_number, kind_of
from rtkit.property.writing import write

SCALARS = (bool, int, float, str, bytes)
"""Annotations that say all about a value: the present one need not be known."""
_FOUND = ", found "
_SHOWN = 40
"""How many characters of a value an error shows."""
_CONTAINERS = (list, tuple, set, frozenset)


def from_value(value: Content, hint: Any, present: object) -> Any:
    """Return the object that a value stands for, like the annotation or what is there now.

    Raises:
        PropertyError: ``bad-value``: none of them fits.
    """
    hint = hint if hint in SCALARS else bare(hint)
    if hint in SCALARS:
        return _scalar(hint, value)
    origin = get_origin(hint)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return _member(hint, value)
    if origin in (typing.Union, types.UnionType):
        return _one_of(get_args(hint), value, present)
    if origin is typing.Literal:
        return _choice(get_args(hint), value)
    if hint is type(None):
        return _nothing(value)
    if isinstance(hint, type) and dataclasses.is_dataclass(hint) and not has_element(hint):
        return _record(hint, value)
    if hint in (Word, Element):
        return check(type_of(hint), value)
    if isinstance(hint, type) and has_element(hint):
        return _structured(hint, value)
    if isinstance(origin, type) and get_args(hint) and not is_array(present):
        if issubclass(origin, Mapping):
            return _mapping(get_args(hint), value)
        if issubclass(origin, Sequence | AbstractSet):
            return _items(origin, get_args(hint), value, present)
    return _like(present, value)


def _like(present: object, value: Content) -> Any:
    """Return the object that is most like the present one."""
    if isinstance(present, Enum):
        return _member(type(present), value)
    if is_array(present):
        return _array(present, value)
    if has_element(present):
        return _structured(type(present), value)
    if isinstance(value, tuple):
        return _sequence(value, present)
    return str(value) if isinstance(value, Word) else value


def _refusal(expected: str, value: Content) -> PropertyError:
    if isinstance(value, bytes):
        return PropertyError("bad-value", f"expected {expected}{_FOUND}bytes")
    text = write(value)
    text = text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…"
    return PropertyError("bad-value", f"expected {expected}{_FOUND}{kind_of(value)} {text}")


def _scalar(hint: type, value: Content) -> object:
    if hint is float and is_number(value):
        return float(value)  # type: ignore[arg-type]
    if hint is str and isinstance(value, str):
        return str(value)
    if isinstance(value, hint) and isinstance(value, bool) is (hint is bool):
        return value
    raise _refusal(hint.__name__, value)


def _structured(kind: type, value: Content) -> Any:
    """Return the object of a class that knows its element."""
    if not isinstance(value, Element):
        raise _refusal(type_of(kind).name, value)
    return kind.from_element(value)  # type: ignore[attr-defined]


def _record(kind: type, value: Content) -> Any:
    """Return a dataclass whose fields are the children of an element."""
    name = kind.__name__.lower()
    if not isinstance(value, Element) or value.name != name:
        raise _refusal(f"<{name}>", value)
    hints = hints_of(kind)
    fields = {each.name: each for each in dataclasses.fields(kind) if each.init}
    given: dict[str, Any] = {}
    for child in value.children:
        if child.name not in fields or child.name in given:
            why = "is there twice" if child.name in given else f"is no field of {name}"
            raise PropertyError("bad-value", f"{child.name}: {why}")
        try:
            given[child.name] = _field(child, hints.get(child.name))
        except PropertyError as error:
            raise PropertyError("bad-value", f"{child.name}: {error}") from None
    missing = dataclasses.MISSING
    for each in fields.values():
        is_needed = each.default is missing and each.default_factory is missing
        if is_needed and each.name not in given:
            raise PropertyError("bad-value", f"{each.name}: is missing")
    try:
        return kind(**given)
    except (ValueError, TypeError) as error:
        raise PropertyError("bad-value", f"{name}: {error}") from error


def _field(child: Element, hint: Any) -> Any:
    value: Value = "" if child.leaf is None else child.leaf
    spec = spec_of(hint, None, "rw", "")
    if child.children:
        is_one = len(child.children) == 1 and spec.type.base != "list"
        value = child.children[0] if is_one else child.children
    return from_value(spec.admit(value), hint, None)


def _nothing(value: Content) -> None:
    if value != ():
        raise _refusal("nothing, which is ()", value)


def _one_of(hints: tuple[Any, ...], value: Content, present: object) -> Any:
    """Return what fits the first of several annotations."""
    reasons = []
    for hint in hints:
        try:
            return from_value(value, hint, present)
        except PropertyError as error:
            if hint not in (None, type(None)):  # a value was given: nobody meant nothing
                reasons.append(str(error))
    # An error inside the value comes before the kinds that it is not at all.
    raise PropertyError("bad-value", "; or ".join(sorted(reasons, key=lambda why: _FOUND in why)))


def _choice(choices: tuple[object, ...], value: Content) -> object:
    for each in choices:
        if type(to_value(each)) is type(value) and to_value(each) == value:
            return each
        if isinstance(each, str) and isinstance(value, str) and each == str(value):
            return each
    raise _refusal(f"one of {' '.join(str(each) for each in choices)}", value)


def _mapping(hints: tuple[Any, ...], value: Content) -> dict[Any, Any]:
    if not isinstance(value, tuple) or not all(
        isinstance(pair, tuple) and len(pair) == 2 for pair in value
    ):
        raise _refusal("a list of (name value)", value)
    key, item = hints
    pairs = [each for each in value if isinstance(each, tuple)]
    return {from_value(one, key, None): from_value(other, item, None) for one, other in pairs}


def _items(kind: type, hints: tuple[Any, ...], value: Content, present: object) -> Any:
    if not isinstance(value, tuple):
        raise _refusal("a list", value)
    if kind is tuple and hints[-1] is not Ellipsis:
        if len(hints) != len(value):
            raise _refusal(f"{len(hints)} items", value)
        wanted = hints
    else:
        wanted = (hints[0],) * len(value)
    made = [_item(index, each, hint)
            for index, (each, hint) in enumerate(zip(value, wanted, strict=True))]  # fmt: skip
    container = kind if kind in _CONTAINERS else type(present)
    if container not in _CONTAINERS:
        container = set if issubclass(kind, AbstractSet) else list
    return container(made)


def _item(index: int, value: Value, hint: Any) -> Any:
    try:
        return from_value(value, hint, None)
    except PropertyError as error:
        raise PropertyError(error.code, f"item {index}: {error}") from None


def _member(kind: type[Enum], value: Content) -> Enum:
    for member in kind:
        if isinstance(value, str) and member.name == str(value):
            return member
    names = " ".join(member.name for member in kind)
    raise PropertyError("bad-value", f"expected one of {names}")


def _array(present: Any, value: Content) -> Any:
    """Return an array like the present one, if it can hold the values as they are."""
    from importlib import import_module

    numpy = import_module("numpy")
    dtype, shape = present.dtype, getattr(present, "shape", ())
    try:
        given = numpy.asarray(_plain(value))
        is_alike = given.dtype.kind == dtype.kind or {given.dtype.kind, dtype.kind} <= {*"iuf"}
        with numpy.errstate(all="ignore"):
            made = given.astype(dtype, casting="unsafe" if is_alike else "safe")
    except (ValueError, TypeError, OverflowError) as error:
        raise PropertyError("bad-value", f"expected numbers of type {dtype}: {error}") from error
    if given.shape != shape:
        raise PropertyError("bad-value", f"expected the shape {shape}, found {given.shape}")
    if dtype.kind in "iu" and not numpy.array_equal(made, given):
        raise _refusal(f"numbers that {dtype} can hold", value)
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
