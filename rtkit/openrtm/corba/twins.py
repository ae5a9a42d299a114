"""Mutable twins of data types: classes as omniORB generates them, one for each frozen data type.

Components keep a value, change it in place and write it again, so a port takes a frozen snapshot
at each write, and hands out a fresh object at each read. Fields may hold anything until then.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from enum import Enum
from functools import cache
from typing import Any, ClassVar, NamedTuple

from rtkit.component.values.codegen import Source, record_maker
from rtkit.component.values.type_layout import (
    ArrayLayout,
    BasicLayout,
    EnumLayout,
    ItemsLayout,
    Layout,
    StructLayout,
    layout_of,
)
from rtkit.component.values.typenames import type_name
from rtkit.errors import Malformed
from rtkit.openrtm.corba.enumerations import ItemsOfEnum, items_of

_STRUCT = 15
"""Number of structures among the kinds of CORBA types."""
Convert = Callable[[Any], Any]
UNFIT = (Malformed, AttributeError, TypeError, ValueError, KeyError)
"""Errors of a value that cannot be carried: a field is not there, or holds what does not fit."""


class StructBase:
    """Base of all structures."""

    frozen_class: ClassVar[type]
    field_names: ClassVar[tuple[str, ...]] = ()
    _NP_RepositoryId: ClassVar[str] = ""

    def __repr__(self) -> str:
        cls = type(self)
        values = ", ".join(f"{each}={getattr(self, each, None)!r}" for each in self.field_names)
        return f"{cls.__module__}.{cls.__name__}({values})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, StructBase) or other.field_names != self.field_names:
            return NotImplemented
        return all(getattr(self, each) == getattr(other, each) for each in self.field_names)

    __hash__ = object.__hash__


@cache
def twin_of(cls: type) -> Any:
    """Return the mutable class of a frozen data type, or the items of an enumeration.

    Raises:
        Malformed: It is no data type.
    """
    id = type_name(cls)
    if issubclass(cls, Enum):
        return items_of(cls, id)
    names = tuple(name for name, _ in layout_of(cls).fields)
    source = Source()
    for name in names:
        source.add(f"self.{name} = {name}")
    body = {
        "__init__": source.finish(f"def coder(self, {', '.join(names)}):"),
        "__module__": id.removeprefix("IDL:").rpartition("/")[0].replace("/", ".") or "_GlobalIDL",
        "__doc__": cls.__doc__,
        "field_names": names,
        "frozen_class": cls,
        "_NP_RepositoryId": id,
    }
    return type(cls.__name__, (StructBase,), body)


def descriptor_of(twin: Any) -> tuple[Any, ...]:
    """Return ``_d_NAME`` of a structure: four entries, then a name and a type for each field."""
    fields = layout_of(twin.frozen_class).fields
    pairs = (part for name, item in fields for part in (name, item.name))
    return (_STRUCT, twin, twin._NP_RepositoryId, twin.__name__, *pairs)  # noqa: SLF001


def frozen_class_of(value: Any) -> type:
    """Return the frozen data type of a value that a port is bound to, or of its class.

    Raises:
        Malformed: It is no structure.
    """
    cls = value if isinstance(value, type) else type(value)
    if not issubclass(cls, StructBase) or cls is StructBase:
        raise Malformed(f"a port carries a structure of an IDL file, not {value!r}")
    return cls.frozen_class


class AliasOf(NamedTuple):
    """Another name for a sequence, an array, a number or a text."""

    name: str
    layout: Layout


def default_of(cls: Any) -> Any:
    """Return a value of a structure with every number 0, every text and sequence empty."""
    if isinstance(cls, AliasOf):
        return _zero(cls.layout)
    if isinstance(cls, ItemsOfEnum):
        return cls._items[0]
    return _zero(layout_of(frozen_class_of(cls)))


def _zero(layout: Layout) -> Any:
    if isinstance(layout, StructLayout):
        return twin_of(layout.cls)(*(_zero(item) for _, item in layout.fields))
    if isinstance(layout, ArrayLayout):
        return [_zero(item) for item in layout.items]
    if isinstance(layout, EnumLayout):
        return twin_of(layout.cls)._items[0]  # noqa: SLF001
    if isinstance(layout, ItemsLayout):
        return "" if layout.item.name == "char" else []
    return layout.zero


# conversion


@cache
def freezer_of(cls: type) -> Convert:
    """Return the function from a mutable value to a frozen one of that class.

    What it raises for a value that does not fit has no form; the port that writes it explains.
    """
    return _compiled(_Freezer(), layout_of(cls))


@cache
def thawer_of(cls: type) -> Convert:
    """Return the function from a frozen value of that class to a new mutable one."""
    return _compiled(_Thawer(), layout_of(cls))


def freezer_of_layout(layout: Layout) -> Convert:
    """Return such a function for a value of a layout, as operations take and return them."""
    if isinstance(layout, StructLayout):
        return freezer_of(layout.cls)
    return _compiled(_Freezer(), layout)


def thawer_of_layout(layout: Layout) -> Convert:
    """Return the function back, for a value of a layout."""
    if isinstance(layout, StructLayout):
        return thawer_of(layout.cls)
    return _compiled(_Thawer(), layout)


def _compiled(writer: _Converter, layout: Layout) -> Convert:
    writer.add(f"return {writer.of(layout, 'value')}")
    convert: Convert = writer.finish("def coder(value):")
    return convert


class _Converter(Source, ABC):
    """Writes the conversion of a value as an expression, with a line for each structure."""

    def of(self, layout: Layout, source: str) -> str:
        """Return the expression of what becomes of the value of an expression."""
        if isinstance(layout, StructLayout):
            return self.struct(layout, source)
        if isinstance(layout, ArrayLayout):
            return self.items(layout.items[0], source)
        if isinstance(layout, ItemsLayout):
            return self.items(layout.item, source)
        return self.scalar(layout, source)

    def struct(self, layout: StructLayout, source: str) -> str:
        if source == "value" or "." not in source:
            held = source
        else:
            held = self.name()
            self.add(f"{held} = {source}")
        fields = ", ".join(self.of(item, f"{held}.{name}") for name, item in layout.fields)
        return f"{self.maker(layout)}({fields})"

    @abstractmethod
    def maker(self, layout: StructLayout) -> str:
        """Return what makes the value of a structure."""

    @abstractmethod
    def items(self, item: Layout, source: str) -> str:
        """Return the expression of the items of a sequence, or an array."""

    @abstractmethod
    def scalar(self, layout: BasicLayout | EnumLayout, source: str) -> str:
        """Return the expression of a number, a text, octets, or an item of an enumeration."""


class _Freezer(_Converter):
    def maker(self, layout: StructLayout) -> str:
        return self.name(record_maker(layout), "make")

    def items(self, item: Layout, source: str) -> str:
        if isinstance(item, BasicLayout) and item.cls is not bytes:
            return (
                f"{self.name(_characters)}({source})" if item.name == "char" else f"tuple({source})"
            )
        return f"tuple(map({self.name(freezer_of_layout(item))}, {source}))"

    def scalar(self, layout: BasicLayout | EnumLayout, source: str) -> str:
        if isinstance(layout, EnumLayout):
            return f"{source}.member"
        if layout.cls is not bytes:
            return source
        name = self.name()
        return (
            f"({name} if ({name} := {source}).__class__ is bytes else {self.name(_octets)}({name}))"
        )


class _Thawer(_Converter):
    def maker(self, layout: StructLayout) -> str:
        return self.name(twin_of(layout.cls), "make")

    def items(self, item: Layout, source: str) -> str:
        if isinstance(item, BasicLayout):
            return f"''.join({source})" if item.name == "char" else f"list({source})"
        return f"list(map({self.name(thawer_of_layout(item))}, {source}))"

    def scalar(self, layout: BasicLayout | EnumLayout, source: str) -> str:
        if not isinstance(layout, EnumLayout):
            return source
        items = {each.member: each for each in twin_of(layout.cls)._items}  # noqa: SLF001
        return f"{self.name(items, 'items')}[{source}]"


def _characters(value: Any) -> tuple[str, ...]:
    return tuple(value.decode("latin-1") if isinstance(value, bytes | bytearray) else value)


def _octets(value: Any) -> bytes:
    if isinstance(value, str):
        return value.encode("latin-1")
    if isinstance(value, int):
        raise Malformed(f"{value} is no sequence of octets")
    return bytes(value)
