"""Data types as interface definitions in text, which viewers of recordings read."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.component.layout import (
    Array,
    Bool,
    Char,
    Enumeration,
    Items,
    Layout,
    Number,
    Octets,
    Struct,
    Text,
    layout_of,
)
from rtkit.component.typenames import type_name
from rtkit.rtc.data_types import scoped_name

ENCODING = "omgidl"
_NUMBERS = {
    "int8": "int8",
    "uint8": "octet",
    "int16": "short",
    "uint16": "unsigned short",
    "int32": "long",
    "uint32": "unsigned long",
    "int64": "long long",
    "uint64": "unsigned long long",
    "float32": "float",
    "float64": "double",
}


def name_of(cls: type) -> str:
    """Return the scoped name of a data type, ``RTC::TimedLong``."""
    return scoped_name(type_name(cls))


def idl_of(cls: type) -> str:
    """Return the definition of a data type behind those of all types that it contains.

    Raises:
        Malformed: It is no data type.
    """
    return "\n".join(_definitions(layout_of(cls), set()))


def has_octets(cls: type) -> bool:
    """Whether values of a data type have octets in them; bytes stand for a value of any type."""
    return cls is bytes or _has_octets(layout_of(cls))


def _has_octets(layout: Layout) -> bool:
    if isinstance(layout, Struct):
        return any(_has_octets(item) for _, item in layout.fields)
    if isinstance(layout, Array):
        return any(map(_has_octets, layout.items))
    return isinstance(layout, Octets) or (isinstance(layout, Items) and _has_octets(layout.item))


def _definitions(layout: Layout, known: set[str]) -> Iterator[str]:
    if isinstance(layout, Items):
        yield from _definitions(layout.item, known)
    elif isinstance(layout, Array):
        for item in layout.items:
            yield from _definitions(item, known)
    elif isinstance(layout, (Struct, Enumeration)):
        name = name_of(layout.cls)
        if name in known:
            return
        known.add(name)
        if isinstance(layout, Enumeration):
            yield _in_module(name, f"enum {_last(name)} {{ {', '.join(_members(layout))} }};")
            return
        for _, item in layout.fields:
            yield from _definitions(item, known)
        fields = "".join(f"    {_field(item, each)};\n" for each, item in layout.fields)
        yield _in_module(name, f"struct {_last(name)} {{\n{fields}  }};")


def _members(layout: Enumeration) -> Iterator[str]:
    for ordinal, (member, number) in enumerate(layout.numbers.items()):
        yield member.name if number == ordinal else f"@value({number}) {member.name}"


def _field(layout: Layout, name: str) -> str:
    if isinstance(layout, Array):
        return f"{_type(layout.items[0])} {name}[{len(layout.items)}]"
    return f"{_type(layout)} {name}"


def _type(layout: Layout) -> str:
    if isinstance(layout, (Struct, Enumeration)):
        return name_of(layout.cls)
    if isinstance(layout, Items):
        return f"sequence<{_type(layout.item)}>"
    if isinstance(layout, Number):
        return _NUMBERS[layout.name]
    if isinstance(layout, (Bool, Char, Text, Octets)):
        return layout.name
    return _type(layout.items[0])


def _in_module(name: str, definition: str) -> str:
    scopes = name.split("::")[:-1]
    return (
        "".join(f"module {each} {{\n" for each in scopes)
        + f"  {definition}\n"
        + "};\n" * len(scopes)
    )


def _last(name: str) -> str:
    return name.rpartition("::")[2]
