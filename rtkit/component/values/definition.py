"""Writes data types as IDL text, by which ports and recordings describe their values."""

from __future__ import annotations

import re
from collections.abc import Iterator
from enum import Enum
from typing import Annotated, get_args, get_origin

from rtkit.component.types import BASIC_TYPES
from rtkit.component.values.type_layout import (
    ArrayLayout,
    EnumLayout,
    ItemsLayout,
    Layout,
    StructLayout,
    layout_of,
    layout_of_hint,
)
from rtkit.component.values.typenames import is_standard, type_name
from rtkit.errors import Malformed
from rtkit.rtc.data_types import scoped_name

ENCODING = "omgidl"
_NUMBERS: dict[str, str] = {
    get_args(kind)[1]: word
    for word, kind in reversed([*BASIC_TYPES.items()])
    if get_origin(kind) is Annotated
}
"""The usual word of interface definitions for each number, by name of its layout."""
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_KEYWORDS = """
abstract any attribute boolean case char component const consumes context custom default double
emits enum eventtype exception factory false finder fixed float getraises home import in inout
interface local long module multiple native object octet oneway out primarykey private provides
public publishes raises readonly sequence setraises short string struct supports switch true
truncatable typedef typeid typeprefix union unsigned uses valuebase valuetype void wchar wstring
"""
_ATTRIBUTE = r"(?m)^( +)(\w+): (.+(?:\n\1 +\S.*)*)"
_known: dict[type, str] = {}


def definition_of(cls: type) -> str:
    """Return the IDL definition of a data type that is not standard; "" where there is none."""
    known = _known.get(cls)
    if known is None:
        try:
            known = "" if cls is bytes or is_standard(type_name(cls)) else idl_of(cls)
        except Malformed:
            known = ""
        _known[cls] = known
    return known


def name_of(cls: type) -> str:
    """Return the scoped name of a data type, ``RTC::TimedLong``."""
    return scoped_name(type_name(cls))


def idl_of(cls: type) -> str:
    """Return the definition of a data type behind those of all types that it contains.

    Raises:
        Malformed: It is no data type, or one that IDL has no words for.
    """
    is_enum = issubclass(cls, Enum)
    layout = layout_of_hint(cls, cls.__name__) if is_enum else layout_of(cls)
    return "\n".join(_definitions(layout, {}))


def has_octets(cls: type) -> bool:
    """Return whether values of a data type have octets in them; bytes stand for any type."""
    return cls is bytes or _has_octets(layout_of(cls))


def _has_octets(layout: Layout) -> bool:
    if isinstance(layout, StructLayout):
        return any(_has_octets(item) for _, item in layout.fields)
    if isinstance(layout, ArrayLayout):
        return any(map(_has_octets, layout.items))
    return _has_octets(layout.item) if isinstance(layout, ItemsLayout) else layout.cls is bytes


def _definitions(layout: Layout, known: dict[str, object]) -> Iterator[str]:
    """Yield the definitions of a layout, each once; `known` has what each name stands for."""
    if isinstance(layout, ItemsLayout):
        yield from _definitions(layout.item, known)
        if isinstance(layout.item, ArrayLayout):
            name = _array_name(layout.item)
            text = f"typedef {_field(layout.item, name)};"
            if _is_new(name, text, known):
                yield text
    elif isinstance(layout, ArrayLayout):
        for item in {id(each): each for each in layout.items}.values():
            yield from _definitions(item, known)
    elif isinstance(layout, (StructLayout, EnumLayout)):
        name = name_of(layout.cls)
        if not _is_new(name, layout.cls, known):
            return
        if isinstance(layout, EnumLayout):
            yield _in_module(name, f"enum {_last(name)} {{ {', '.join(_members(layout))} }};")
            return
        for _, item in layout.fields:
            yield from _definitions(item, known)
        docs, summary = docs_of(layout.cls), _summary(layout.cls)
        fields = "".join(
            f"    {_field(item, each)};{'  // ' * (each in docs)}{docs.get(each, '')}\n"
            for each, item in layout.fields
        )
        about = f"// {summary}\n  " if summary else ""
        yield _in_module(name, f"{about}struct {_last(name)} {{\n{fields}  }};")


def _is_new(name: str, meant: object, known: dict[str, object]) -> bool:
    if name in known and known[name] != meant:
        raise Malformed(f"two types are called {name}")
    is_new = name not in known
    known[name] = meant
    return is_new


def docs_of(cls: type) -> dict[str, str]:
    """Return what the docstring of a class says of its attributes, a line for each."""
    text = (cls.__doc__ or "").partition("Attributes:\n")[2]
    return {name: " ".join(about.split()) for _, name, about in re.findall(_ATTRIBUTE, text)}


def _summary(cls: type) -> str:
    """Return the first line of a docstring, unless a program wrote it of the name alone."""
    first = (cls.__doc__ or "").strip().partition("\n")[0]
    is_made = first.startswith((f"{cls.__name__}(", f"Structure {cls.__name__}"))
    return "" if is_made or first == cls.__name__ else first


def _members(layout: EnumLayout) -> Iterator[str]:
    expected = 0
    for member, number in layout.numbers.items():
        if number < 0:
            raise Malformed(f"{member} is below 0, which IDL has no words for")
        name = _word(member.name or "")
        yield name if number == expected else f"@value({number}) {name}"
        expected = number + 1


def _field(layout: Layout, name: str) -> str:
    sizes = ""
    while isinstance(layout, ArrayLayout):
        if any(item != layout.items[0] for item in layout.items):
            raise Malformed(f"{name} is of several types, which IDL has no words for")
        sizes += f"[{len(layout.items)}]"
        layout = layout.items[0]
    return f"{word_of(layout)} {_word(name)}{sizes}"


def word_of(layout: Layout) -> str:
    """Return what stands for a type where a field of it is declared."""
    if isinstance(layout, (StructLayout, EnumLayout)):
        return "::".join(map(_word, name_of(layout.cls).split("::")))
    if isinstance(layout, ItemsLayout):
        item = word_of(layout.item)
        return f"sequence<{item}{' ' * item.endswith('>')}>"  # >> would shift
    if isinstance(layout, ArrayLayout):
        return _array_name(layout)
    return _NUMBERS.get(layout.name, layout.name)


def _array_name(layout: ArrayLayout) -> str:
    """Return the name for an array, as sequences can only be of types that have one."""
    inner = layout.items[0]
    item = _array_name(inner) if isinstance(inner, ArrayLayout) else word_of(inner)
    return "_".join(["array", str(len(layout.items)), *re.findall(r"\w+", item)])


def _in_module(name: str, definition: str) -> str:
    scopes = name.split("::")[:-1]
    return (
        "".join(f"module {_word(each)} {{\n" for each in scopes)
        + f"  {definition}\n"
        + "};\n" * len(scopes)
    )


def _last(name: str) -> str:
    return _word(name.rpartition("::")[2])


def _word(name: str) -> str:
    """Return a name as IDL writes it: behind an underscore if it looks like a keyword."""
    if not _NAME.fullmatch(name):
        raise Malformed(f"{name} is no name in IDL")
    return f"_{name}" if name.lower() in _KEYWORDS.split() else name
