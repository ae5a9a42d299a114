"""Reads values written as JSON and checks them against a data type; never evaluates text.

``{"tm": {"sec": 1, "nsec": 0}, "data": 3}``; a time stamp that is left out is filled in by the
caller, and for a type of nothing but ``tm`` and ``data`` the data alone will do: ``3``. Octets are
a list of numbers, or ``{"base64": "AAEC"}``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NoReturn

from rtkit.component.types import Time
from rtkit.component.values.type_layout import (
    ArrayLayout,
    BasicLayout,
    EnumLayout,
    ItemsLayout,
    Layout,
    StructLayout,
    complaint,
    layout_of,
    zero,
)
from rtkit.errors import Malformed
from rtkit.rtc.nearest import did_you_mean

_STAMP = "tm"
_DATA = "data"
_BASE64 = "base64"
_NAMED = ("NaN", "Infinity", "-Infinity")
"""Numbers that JSON has no form for, written as texts."""


class Literal:
    """A value of a data type read from JSON text; `at` gives it with a time stamp.

    Attributes:
        is_stamped: Whether the text itself says the time.
    """

    def __init__(self, cls: type, text: str) -> None:
        try:
            data = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise Malformed(f"{cls.__name__}: not JSON: {error}: {_short(text)}") from None
        self._make = cls
        if cls is bytes:
            self._fields: dict[str, Any] = {}
            self._whole = _octets(data, "bytes")
            self.is_stamped = True
            return
        layout = layout_of(cls)
        names = [name for name, _ in layout.fields]
        if names == [_STAMP, _DATA] and not _is_whole(data, dict(layout.fields)[_DATA]):
            data = {_DATA: data}
        value = _read(layout, data, cls.__name__)
        reason = complaint(layout, value, cls.__name__)
        if reason:
            raise Malformed(reason)
        self._whole = value
        self._fields = {name: getattr(value, name) for name in names}
        self.is_stamped = not _has_stamp(layout) or _STAMP in data

    def at(self, now: Time) -> Any:
        """Return the value; its time stamp is `now` unless the text says one."""
        if self.is_stamped:
            return self._whole
        return self._make(**{**self._fields, _STAMP: now})


def zero_value(cls: type, now: Time) -> Any:
    """Return the value of `cls` with everything zero or empty, stamped `now`."""
    if cls is bytes:
        return b""
    layout = layout_of(cls)
    value = zero(layout)
    if not _has_stamp(layout):
        return value
    fields = {name: getattr(value, name) for name, _ in layout.fields}
    return cls(**{**fields, _STAMP: now})


def _is_whole(data: Any, inner: Layout) -> bool:
    """Return whether a literal of a type of stamp and data has both, not the data alone."""
    return isinstance(data, dict) and (
        _DATA in data
        or not (isinstance(inner, StructLayout) or getattr(inner, "cls", None) is bytes)
    )


def _has_stamp(layout: StructLayout) -> bool:
    return any(
        name == _STAMP and isinstance(item, StructLayout) and item.cls is Time
        for name, item in layout.fields
    )


def _read(layout: Layout, data: Any, where: str) -> Any:
    if isinstance(layout, StructLayout):
        return _record(layout, data, where)
    if isinstance(layout, (ItemsLayout, ArrayLayout)):
        return _sequence(layout, data, where)
    if isinstance(layout, EnumLayout):
        return _member(layout, data, where)
    return _basic(layout, data, where)


def _basic(layout: BasicLayout, data: Any, where: str) -> Any:
    if layout.cls is bytes:
        return _octets(data, where)
    if layout.cls is float and isinstance(data, str) and data in _NAMED:
        return float(data)
    accepted = (int, float) if layout.cls is float else layout.cls
    is_truth = isinstance(data, bool)
    if not isinstance(data, accepted) or (is_truth and layout.cls is not bool):
        _wrong(where, data, layout.name)
    return _float(data, where) if layout.cls is float else data


def _float(data: Any, where: str) -> float:
    try:
        return float(data)
    except OverflowError:
        _wrong(where, data, "float64")


def _record(layout: StructLayout, data: Any, where: str) -> Any:
    if not isinstance(data, Mapping):
        _wrong(where, data, layout.name)
    known = dict(layout.fields)
    for name in data:
        if name not in known:
            hint = did_you_mean(name, known)
            raise Malformed(f"{where}: no field {name}{hint}; it has {', '.join(known)}")
    values = {}
    for name, item in layout.fields:
        own = f"{where}.{name}"
        values[name] = _read(item, data[name], own) if name in data else zero(item)
    return layout.cls(**values)


def _sequence(layout: ItemsLayout | ArrayLayout, data: Any, where: str) -> Any:
    if not isinstance(data, list):
        _wrong(where, data, layout.name)
    if isinstance(layout, ItemsLayout):
        return layout.make(
            _read(layout.item, item, f"{where}[{index}]") for index, item in enumerate(data)
        )
    if len(data) != len(layout.items):
        _wrong(where, data, layout.name)
    return tuple(
        _read(item, one, f"{where}[{index}]")
        for index, (item, one) in enumerate(zip(layout.items, data, strict=True))
    )


def _octets(data: Any, where: str) -> bytes:
    if isinstance(data, dict) and data.keys() == {_BASE64}:
        return _unpacked(data[_BASE64], where)
    if not isinstance(data, list):
        _wrong(where, data, "sequence<octet>")
    for item in data:
        if type(item) is not int or not 0 <= item < 256:
            _wrong(where, item, "octet")
    return bytes(data)


def _unpacked(text: Any, where: str) -> bytes:
    import base64

    try:
        return base64.b64decode(text, validate=True)
    except (ValueError, TypeError):
        raise Malformed(f"{where}: not base64: {_short(str(text))}") from None


def _member(layout: EnumLayout, data: Any, where: str) -> Any:
    for member, number in layout.numbers.items():
        if data == member.name or (type(data) is int and data == number):
            return member
    known = ", ".join(member.name for member in layout.numbers)
    raise Malformed(f"{where}: {_short(repr(data))} is none of {known}")


def _wrong(where: str, data: Any, wanted: str) -> NoReturn:
    given = _short(json.dumps(data, ensure_ascii=False))
    raise Malformed(f"{where}: {given} is not a value of type {wanted}")


def _short(text: str) -> str:
    return text if len(text) <= 60 else text[:59] + "…"
