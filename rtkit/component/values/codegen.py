"""Compiles a layout into Python source that writes or reads CDR.

Scalars that follow each other become one run, packed by one call of the struct module. A number
is aligned to its size, counted from the end of the header. At the start of a message the position
is known; after something of variable length it is not, so such a run has one struct for each of
the eight positions. Arrays are written out, but for long ones of things of variable length, which
are loops: code of arrays in arrays would grow with the product of their lengths.
"""

from __future__ import annotations

import struct
from abc import ABC, abstractmethod
from collections.abc import Callable
from types import MemberDescriptorType
from typing import Any, TypeGuard, cast

from rtkit.component.values import arrays
from rtkit.component.values.cdr_parts import HELPERS, Octets
from rtkit.component.values.type_layout import (
    ArrayLayout,
    BasicLayout,
    EnumLayout,
    ItemsLayout,
    Layout,
    StructLayout,
)

_SIZES = {"b": 1, "B": 1, "?": 1, "c": 1, "h": 2, "H": 2, "i": 4, "I": 4, "f": 4}
_HEADER = 4
_INDENT = "    "
_UTF_16 = {"<": "utf-16-le", ">": "utf-16-be"}
_PACKED = {
    "boolean": ("?", "_as_truth({})"),
    "char": ("c", "{}.encode('latin-1')"),
    "wchar": ("H", "_unit(ord({}))"),
}
_UNPACKED = {
    "boolean": ("B", "_truth({})"),
    "char": ("B", "chr({})"),
    "wchar": ("H", "chr(_unit({}))"),
}
"""Format character of scalars that the struct module does not give as they are, and expression."""


def compile_encoder(layout: StructLayout, order: str = "<") -> Callable[[Any], bytes]:
    """Return a function from value to bytes; it raises whatever goes wrong.

    `order` is ``<`` or ``>``.
    """
    encode: Callable[[Any], bytes] = _Encoder(order).compile(layout, "b''.join(parts)")
    return encode


def compile_splitter(layout: StructLayout, order: str = "<") -> Callable[[Any], list[Octets]]:
    """Return such a function, to the parts that make up the bytes.

    Parts that are octets, or an array, of the value are no copies of them.
    """
    split: Callable[[Any], list[Octets]] = _Encoder(order).compile(layout, "parts")
    return split


def is_fixed(layout: StructLayout) -> bool:
    """Return whether all values have one length."""
    return not _is_variable(layout)


def compile_decoder(layout: StructLayout, order: str) -> Callable[[Octets], tuple[Any, int]]:
    """Return a function from bytes to the value and the position behind it.

    It raises whatever goes wrong. `order` is ``<`` or ``>``.
    """
    return _Decoder(order).compile(layout)


def _size(code: str) -> int:
    return _SIZES.get(code, 8)


def _padded(codes: str, order: str, position: int) -> struct.Struct:
    """Return the struct that holds these scalars when the first is met at `position`."""
    form, at = order, position - _HEADER
    for code in codes:
        pad = -at % _size(code)
        form += "x" * pad + code
        at += pad + _size(code)
    return struct.Struct(form)


class Source:
    """Lines of a function under construction, with the objects that they refer to."""

    def __init__(self, **scope: Any) -> None:
        self.lines: list[str] = []
        self.scope = scope
        self.depth = 1
        self._count = 0

    def name(self, value: Any = None, stem: str = "v") -> str:
        """Return a new name, of an object where one is given."""
        self._count += 1
        name = f"{stem}{self._count}"
        if value is not None:
            self.scope[name] = value
        return name

    def add(self, line: str) -> None:
        """Add a line, indented by the present depth."""
        self.lines.append(_INDENT * self.depth + line)

    def finish(self, head: str) -> Any:
        """Return the function ``coder`` that begins with `head`."""
        source = "\n".join([head, *self.lines])
        exec(source, self.scope)
        return self.scope["coder"]


class _Cdr(Source, ABC):
    """Code that writes or reads CDR: scalars wait until they can be packed in one run.

    Attributes:
        is_fixed: Whether the position is still known, counted from the beginning.
        codes: Format characters of the scalars that wait, whose expressions are `names`.
    """

    def __init__(self, order: str) -> None:
        header = b"\x00\x01\x00\x00" if order == "<" else bytes(_HEADER)
        super().__init__(**HELPERS, _header=header)
        self.order = order
        self.is_fixed = True
        self.codes = ""
        self.names: list[str] = []

    def run(self) -> str:
        """Return the name of the table of structs for the scalars that are waiting."""
        table = tuple(_padded(self.codes, self.order, position) for position in range(8))
        return self.name(table, "run")

    def flush(self) -> None:
        if self.codes:
            self.settle()

    @abstractmethod
    def settle(self) -> None:
        """Emit what waits, if anything: from here on ``at`` is the position."""


class _Encoder(_Cdr):
    def compile(self, layout: StructLayout, result: str) -> Callable[[Any], Any]:
        """Return the function, to what `result` makes of the list of parts if it is not fixed."""
        self.write(layout, "value")
        if self.is_fixed:
            self.add(f"return {self.fixed()[0]}")
        else:
            self.flush()
            self.add(f"return {result}")
        coder: Callable[[Any], Any] = self.finish("def coder(value):")
        return coder

    def write(self, layout: Layout, value: str) -> None:
        if isinstance(layout, StructLayout):
            self.write_struct(layout, value)
        elif isinstance(layout, ArrayLayout) and _is_loop(layout):
            self.take_items(value)
            self.add(f"if len({value}) != {len(layout.items)}: raise ValueError('wrong length')")
            self.settle()
            self.write_each(layout.items[0], value)
        elif isinstance(layout, ArrayLayout):
            names = [self.name() for _ in layout.items]
            self.take_items(value)
            self.add(f"{', '.join(names)}, = {value}")
            for name, item in zip(names, layout.items, strict=True):
                self.write(item, name)
        elif isinstance(layout, ItemsLayout):
            self.write_items(layout, value)
        elif layout.code:
            code, expression = self.scalar(layout, value)
            self.codes += code
            self.names.append(expression)
        else:
            self.write_text(layout.name, value)

    def write_struct(self, layout: StructLayout, value: str) -> None:
        for field, item in layout.fields:
            if _is_scalar(item):
                self.write(item, f"{value}.{field}")
            else:
                name = self.name()
                self.add(f"{name} = {value}.{field}")
                self.write(item, name)

    def scalar(self, layout: BasicLayout | EnumLayout, value: str) -> tuple[str, str]:
        """Return the format character of a scalar, and the expression of what is packed."""
        if isinstance(layout, EnumLayout):
            return "i", f"{self.name(dict(layout.numbers), 'numbers')}[{value}]"
        code, form = _PACKED.get(layout.name, (layout.code, "{}"))
        return code, form.format(value)

    def write_text(self, kind: str, value: str) -> None:
        data = self.name()
        if kind == "wstring":
            self.add(f"{data} = {value}.encode('{_UTF_16[self.order]}')")
        elif kind == "string":
            self.add(f"{data} = {value}.encode() + b'\\0'")
            self.add(f"if {data}.find(0) != len({data}) - 1: raise ValueError('NUL in a string')")
        else:
            self.add(f"{data} = _as_octets({value})")
        self.count(f"len({data})")
        self.append(data)

    def take_items(self, value: str) -> None:
        """Emit code that turns an array into a list and refuses other types than sequences."""
        self.add(f"if {value}.__class__ is not tuple: {value} = _as_items({value})")

    def write_items(self, layout: ItemsLayout, value: str) -> None:
        if layout.is_array:
            self.write_array(layout, value)
            return
        self.take_items(value)
        self.count(f"len({value})")
        item = layout.item
        if _is_scalar(item):
            code, expression = self.scalar(item, "item")
            self.add(f"if len({value}):")
            self.depth += 1
            if _size(code) > _HEADER:
                self.pad(_size(code))
            items = value if expression == "item" else f"[{expression} for item in {value}]"
            data = self.name()
            self.add(f"{data} = _pack(f'{self.order}{{len({value})}}{code}', *{items})")
            self.append(data)
            self.depth -= 1
            return
        self.write_each(item, value)

    def write_array(self, layout: ItemsLayout, value: str) -> None:
        item = cast(BasicLayout, layout.item)
        code, _ = self.scalar(item, "item")
        data, count = self.name(), self.name()
        octets = self.name(arrays.writer_of(self.order + item.code), "octets")
        self.add(f"{data} = {octets}({value})")
        self.add(f"{count} = len({data}) // {_size(code)}")
        self.count(count)
        self.add(f"if {count}:")
        self.depth += 1
        if _size(code) > _HEADER:
            self.pad(_size(code))
        self.append(data)
        self.depth -= 1

    def pad(self, size: int) -> None:
        """Emit the octets that lie between the number of items and these."""
        self.add(f"parts.append(_padding[{_HEADER} - at & {size - 1}])")
        self.add(f"at += {_HEADER} - at & {size - 1}")

    def write_each(self, item: Layout, value: str) -> None:
        name = self.name()
        self.add(f"for {name} in {value}:")
        self.depth += 1
        self.write(item, name)
        self.flush()
        self.depth -= 1

    def count(self, expression: str) -> None:
        """Emit a length, with the scalars that wait before it."""
        self.codes += "I"
        self.names.append(expression)
        self.flush()

    def append(self, data: str) -> None:
        self.add(f"parts.append({data})")
        self.add(f"at += len({data})")

    def settle(self) -> None:
        if self.is_fixed:
            packed, size = self.fixed()
            self.add(f"parts = [{packed}]")
            self.add(f"at = {size}")
            self.is_fixed = False
        elif self.codes:
            self.add(f"run = {self.run()}[at & 7]")
            self.add(f"parts.append(run.pack({', '.join(self.names)}))")
            self.add("at += run.size")
        self.codes = ""
        self.names = []

    def fixed(self) -> tuple[str, int]:
        """Return the expression that packs header and first run, and their size."""
        form = struct.Struct(self.order + "4s" + _padded(self.codes, "", _HEADER).format)
        return f"{self.name(form, 'run')}.pack(_header, {', '.join(self.names)})", form.size


class _Decoder(_Cdr):
    def compile(self, layout: StructLayout) -> Callable[[Octets], tuple[Any, int]]:
        result = self.read(layout)
        self.flush()
        self.add(f"return {result}, at")
        coder: Callable[[Octets], tuple[Any, int]] = self.finish("def coder(data):")
        return coder

    def read(self, layout: Layout) -> str:
        """Emit code that reads a value; return the expression for it, valid once flushed."""
        if isinstance(layout, StructLayout):
            values = [(field, self.read(item)) for field, item in layout.fields]
            if is_plain_record(layout):
                made = self.name(record_maker(layout), "make")
                return f"{made}({', '.join(value for _, value in values)})"
            made = self.name(layout.cls, "make")
            return f"{made}({', '.join(f'{field}={value}' for field, value in values)})"
        if isinstance(layout, ArrayLayout) and _is_loop(layout):
            self.settle()
            return f"tuple({self.read_each(layout.items[0], str(len(layout.items)))})"
        if isinstance(layout, ArrayLayout):
            return f"({''.join(self.read(item) + ', ' for item in layout.items)})"
        if isinstance(layout, ItemsLayout):
            return self.read_items(layout)
        if not layout.code:
            return self.read_text(layout.name)
        name = self.name()
        code, expression = self.scalar(layout, name)
        self.codes += code
        self.names.append(name)
        return expression

    def scalar(self, layout: BasicLayout | EnumLayout, value: str) -> tuple[str, str]:
        """Return the format character of a scalar, and the expression of what was unpacked."""
        if isinstance(layout, EnumLayout):
            members = {number: member for member, number in layout.numbers.items()}
            return "i", f"_member({self.name(members, 'members')}, {value})"
        code, form = _UNPACKED.get(layout.name, (layout.code, "{}"))
        return code, form.format(value)

    def read_text(self, kind: str) -> str:
        length = self.count()
        result = self.name()
        read = "_text" if kind == "string" else "_octets"
        tail = f".decode('{_UTF_16[self.order]}')" if kind == "wstring" else ""
        self.add(f"{result} = {read}(data, at, {length}){tail}")
        self.add(f"at += {length}")
        return result

    def read_items(self, layout: ItemsLayout) -> str:
        item = layout.item
        if layout.is_array:
            return self.read_array(item)
        if _is_scalar(item):
            return self.read_scalars(layout, item)
        count = self.count()
        self.add(f"_fits(data, at, {count}, {_least(item)})")
        result = self.read_each(item, count)
        return result if layout.make is list else f"tuple({result})"

    def read_each(self, item: Layout, count: str) -> str:
        result = self.name()
        self.add(f"{result} = []")
        self.add(f"for _ in range({count}):")
        self.depth += 1
        value = self.read(item)
        self.flush()
        self.add(f"{result}.append({value})")
        self.depth -= 1
        return result

    def read_scalars(self, layout: ItemsLayout, item: BasicLayout | EnumLayout) -> str:
        code, expression = self.scalar(item, "item")
        count = self.count()
        result = self.name()
        size = _size(code)
        if size > _HEADER:
            self.add(f"if {count}: at += {_HEADER} - at & {size - 1}")
        self.add(f"_fits(data, at, {count}, {size})")
        self.add(f"{result} = _unpack(f'{self.order}{{{count}}}{code}', data, at)")
        self.add(f"at += {count} * {size}")
        if expression != "item":
            return f"{layout.make.__name__}([{expression} for item in {result}])"
        return f"list({result})" if layout.make is list else result

    def read_array(self, item: Layout) -> str:
        code, _ = self.scalar(cast(BasicLayout, item), "item")
        size, count, result = _size(code), self.count(), self.name()
        if size > _HEADER:
            self.add(f"if {count}: at += {_HEADER} - at & {size - 1}")
        self.add(f"if {count} * {size} > len(data) - at: _fits(data, at, {count}, {size})")
        view = self.name(arrays.reader_of(self.order + cast(BasicLayout, item).code), "view")
        self.add(f"{result} = {view}(data, {count}, at)")
        self.add(f"at += {count} * {size}")
        return result

    def count(self) -> str:
        """Emit code that reads the length of a variable-length value; return its name."""
        name = self.name()
        self.codes += "I"
        self.names.append(name)
        self.flush()
        return name

    def settle(self) -> None:
        names = ", ".join(self.names)
        if self.is_fixed:
            fixed = _padded(self.codes, self.order, _HEADER)
            if names:
                name = self.name(fixed, "run")
                self.add(f"{names}, = {name}.unpack_from(data, {_HEADER})")
            self.add(f"at = {_HEADER + fixed.size}")
            self.is_fixed = False
        elif self.codes:
            self.add(f"run = {self.run()}[at & 7]")
            self.add(f"{names}, = run.unpack_from(data, at)")
            self.add("at += run.size")
        self.codes = ""
        self.names = []


def _is_scalar(layout: Layout) -> TypeGuard[BasicLayout | EnumLayout]:
    return isinstance(layout, BasicLayout | EnumLayout) and bool(layout.code)


def _is_loop(layout: ArrayLayout) -> bool:
    first, *others = layout.items
    return len(others) > 2 and all(each is first for each in others) and _is_variable(first)


def _is_variable(layout: Layout) -> bool:
    """Return whether values of it differ in length."""
    if isinstance(layout, StructLayout):
        return any(_is_variable(item) for _, item in layout.fields)
    if isinstance(layout, ArrayLayout):
        return any(map(_is_variable, {id(item): item for item in layout.items}.values()))
    return not _is_scalar(layout)


def is_plain_record(layout: StructLayout) -> bool:
    """Return whether a class is a frozen dataclass with slots and a plain constructor."""
    cls: Any = layout.cls
    made = cls.__dataclass_params__
    return bool(
        made.frozen
        and made.init
        and "__init__" in vars(cls)
        and cls.__new__ is object.__new__
        and not hasattr(cls, "__post_init__")
        and all(
            isinstance(getattr(cls, name, None), MemberDescriptorType) for name, _ in layout.fields
        )
    )


def record_maker(layout: StructLayout) -> Callable[..., Any]:
    """Return a function that makes such a record in half the time of its constructor.

    The constructor of a frozen dataclass looks up and checks each field by its name.
    """
    source = Source(new=object.__new__, cls=layout.cls)
    source.add("made = new(cls)")
    for index, (field, _) in enumerate(layout.fields):
        setter = source.name(getattr(layout.cls, field).__set__, "set")
        source.add(f"{setter}(made, a{index})")
    source.add("return made")
    arguments = ", ".join(f"a{index}" for index in range(len(layout.fields)))
    maker: Callable[..., Any] = source.finish(f"def coder({arguments}):")
    return maker


def _least(layout: Layout) -> int:
    """Return the least number of bytes that a value takes, to bound counts by what is there."""
    if isinstance(layout, StructLayout):
        return sum(_least(item) for _, item in layout.fields)
    if isinstance(layout, ArrayLayout):
        if _is_loop(layout):
            return len(layout.items) * _least(layout.items[0]) or 1
        return sum(_least(item) for item in layout.items) or 1
    return _size(layout.code) if _is_scalar(layout) else 4
