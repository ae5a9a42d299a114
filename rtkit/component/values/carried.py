"""Carries values within a process: readers get the same values as from another process.

The result is that of the codec: values that do not fit are refused where they are written, and
parts that the writer could still change (arrays, lists, bytearrays) are copied. An immutable value
that the codec would leave equal is passed as it is. Each type has a generated test for that, so
that small values cost a fraction of a microsecond.

See decision 43.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from enum import Flag
from typing import Any, cast

from rtkit.component.values.arrays import is_frozen
from rtkit.component.values.codec import codec_for, encoder_for
from rtkit.component.values.codegen import Source
from rtkit.component.values.type_layout import (
    ArrayLayout,
    BasicLayout,
    EnumLayout,
    ItemsLayout,
    Layout,
    StructLayout,
    layout_of,
)

Test = Callable[[Any], bool]
"""Returns whether readers may get a value as it is."""

_FLOAT32 = struct.Struct("f")
_tests: dict[type, Test] = {}


def test_of(cls: type) -> Test:
    """Return the test for values of a dataclass, or of bytes.

    Raises:
        Malformed: The type has a field that cannot be carried.
    """
    known = _tests.get(cls)
    if known is None:
        known = _tests[cls] = _is_bytes if cls is bytes else compile_test(layout_of(cls))
    return known


def carried(cls: type, value: Any) -> Any:
    """Return the value that a reader gets for a written one.

    Raises:
        Malformed: It is no value of the type; names field and type.
    """
    if test_of(cls)(value):
        return value
    codec = codec_for(cls)
    return codec.decode(codec.encode(value))


def passage(
    written: type, read: type, *, is_big_endian: bool = False
) -> Callable[[Any], Any] | None:
    """Return the function from a value written in this process to the one that a port here reads.

    None where that is the value itself: both ports have one type, whose values are immutable.
    The order of bytes matters to a port that reads bytes.
    """
    if written is read and (written is bytes or not is_changeable(layout_of(written))):
        return None
    encode = encoder_for(written, is_big_endian=is_big_endian)
    decode = codec_for(read).decode
    return lambda value: decode(encode(value))


def is_changeable(layout: Layout) -> bool:
    """Return whether readers could change values, so that each has to get one of its own."""
    if isinstance(layout, StructLayout):
        return not _is_frozen(layout.cls) or any(is_changeable(item) for _, item in layout.fields)
    if isinstance(layout, ArrayLayout):
        return any(map(is_changeable, layout.items))
    return isinstance(layout, ItemsLayout) and (layout.make is list or is_changeable(layout.item))


def compile_test(layout: Layout) -> Test:
    """Return the test for values of a layout."""
    if is_changeable(layout):
        return _never
    return _Tester().compile(layout)


def _is_frozen(cls: Any) -> bool:
    return bool(cls.__dataclass_params__.frozen)


def _is_bytes(value: Any) -> bool:
    return value.__class__ is bytes


def _never(value: Any) -> bool:
    return False


class _Tester(Source):
    """Writes a test as one expression; each of its parts evaluates its source once."""

    def compile(self, layout: Layout) -> Test:
        self.add(f"return {self._of(layout, 'value')}")
        test: Test = self.finish("def coder(value):")
        return test

    def _of(self, layout: Layout, source: str) -> str:
        if isinstance(layout, StructLayout):
            name = self.name()
            head = f"({name} := {source}).__class__ is {self.name(layout.cls)}"
            tests = [self._of(item, f"{name}.{field}") for field, item in layout.fields]
            return " and ".join([head, *tests])
        if isinstance(layout, ArrayLayout):
            name = self.name()
            head = f"({name} := {source}).__class__ is tuple and len({name}) == {len(layout.items)}"
            tests = [self._of(item, f"{name}[{at}]") for at, item in enumerate(layout.items)]
            return " and ".join([head, *tests])
        if isinstance(layout, ItemsLayout) and layout.is_array:
            return f"{self.name(is_frozen)}({source}, '{cast(BasicLayout, layout.item).code}')"
        if isinstance(layout, ItemsLayout):
            name = self.name()
            return f"({name} := {source}).__class__ is tuple and {self._each(layout, name)}"
        return self._scalar(layout, source)

    def _each(self, layout: ItemsLayout, name: str) -> str:
        """Return a test of a tuple's items without a step of Python for each, where possible."""
        item = layout.item
        if isinstance(item, (StructLayout, ArrayLayout, ItemsLayout)):
            return f"all(map({self.name(compile_test(item))}, {name}))"
        are_all = f"(not {name} or set(map(type, {name})) == {{{self.name(item.cls)}}}"
        if item.cls is int and isinstance(item, BasicLayout):
            low, high = item.bounds
            return f"{are_all} and {low} <= min({name}) and max({name}) <= {high})"
        leaf = _leaf(item)
        return f"{are_all} and all(map({self.name(leaf)}, {name})))" if leaf else f"{are_all})"

    def _scalar(self, layout: BasicLayout | EnumLayout, source: str) -> str:
        kind, name = self.name(layout.cls), self.name()
        if layout.cls is int and isinstance(layout, BasicLayout):
            low, high = layout.bounds
            return f"({name} := {source}).__class__ is {kind} and {low} <= {name} <= {high}"
        leaf = _leaf(layout)
        if leaf is None:
            return f"{source}.__class__ is {kind}"
        return f"({name} := {source}).__class__ is {kind} and {self.name(leaf)}({name})"


def _leaf(layout: BasicLayout | EnumLayout) -> Test | None:
    """Return the test for a scalar that has the right class already, None where all pass."""
    if isinstance(layout, EnumLayout):
        return layout.numbers.__contains__ if issubclass(layout.cls, Flag) else None
    return _LEAVES.get(layout.name)


def _is_float32(value: float) -> bool:
    try:
        rounded: float = _FLOAT32.unpack(_FLOAT32.pack(value))[0]
    except OverflowError:
        return False
    return rounded == value


def _is_char(value: str) -> bool:
    return len(value) == 1 and value < "\u0100"


def _is_wide_char(value: str) -> bool:
    return len(value) == 1 and (value < "\ud800" or "\ue000" <= value <= "\uffff")


def _is_text(value: str) -> bool:
    return "\0" not in value and _is_wide_text(value)


def _is_wide_text(value: str) -> bool:
    if value.isascii():
        return True
    try:
        value.encode()
    except UnicodeEncodeError:  # half of a surrogate pair
        return False
    return True


_LEAVES: dict[str, Test] = {
    "float32": _is_float32,
    "char": _is_char,
    "wchar": _is_wide_char,
    "string": _is_text,
    "wstring": _is_wide_text,
}
