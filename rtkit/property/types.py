"""Declared types of properties: check values and read the payload of a request.

Source: `property-service` reference, section 3: ``number integer boolean word string text bytes
vector vector[n] list list<T> marker element any``.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import NamedTuple

from rtkit.property.codes import PropertyError
from rtkit.property.limits import LIMITS
from rtkit.property.reading import lone_number, read
from rtkit.property.values import Element, Value, Word, is_number, is_vector, kind_of
from rtkit.property.writing import write

Content = Value | bytes
"""Content of a property: a value, or the bytes of an opaque one."""

_NUMERIC = frozenset({"number", "integer", "vector"})
_TEXTUAL = frozenset({"word", "string", "text", "bytes"})
SIMPLE = _NUMERIC | _TEXTUAL | {"boolean", "list", "marker", "element", "any"}
_SIZED = r"vector\[(\d{1,6})\]"
_OF = r"list<(.+)>"


class Type(NamedTuple):
    """Declared type of a property.

    Attributes:
        name: As it was declared.
        base: The word without size or item type.
        size: How many numbers a vector has, None for any.
        item: Type of the items of a list, None for any.
    """

    name: str
    base: str
    size: int | None = None
    item: Type | None = None


@lru_cache(512)
def parse_type(name: str, depth: int = 0) -> Type:
    """Read the name of a type.

    Raises:
        PropertyError: ``bad-value``: there is no such type.
    """
    if name in SIMPLE:
        return Type(name, name)
    sized, of = re.fullmatch(_SIZED, name), re.fullmatch(_OF, name)
    if sized:
        return Type(name, "vector", size=int(sized[1]))
    if of and depth < 8:
        return Type(name, "list", item=parse_type(of[1], depth + 1))
    raise PropertyError("bad-value", f"no such type: {name[:80]}")


def check(kind: Type, value: Content) -> Content:
    """Return a value that is of a type; a word will do for a string, and the other way about.

    Raises:
        PropertyError: ``bad-value``.
    """
    base = kind.base
    if base == "any":
        return value
    if base == "number" and is_number(value):
        return value
    if base == "integer" and isinstance(value, int) and not isinstance(value, bool):
        return value
    if base == "boolean" and isinstance(value, bool):
        return value
    if base in ("string", "text") and isinstance(value, str):
        return str(value)
    if base == "bytes" and isinstance(value, bytes):
        return value
    if base == "word" and isinstance(value, str):
        return _as_word(value)
    if base == "vector" and is_vector(value) and kind.size in (None, len(_group(value))):
        return value
    if base == "list" and isinstance(value, tuple):
        item = kind.item
        return value if item is None else tuple([_item(item, each) for each in value])
    if isinstance(value, Element) and base in ("element", "marker"):
        return _marker(value) if base == "marker" else value
    raise PropertyError("bad-value", f"expected {kind.name}, found {_described(value)}")


def _group(value: Content) -> tuple[Value, ...]:
    return value if isinstance(value, tuple) else ()


def _item(kind: Type, value: Value) -> Value:
    checked = check(kind, value)
    assert not isinstance(checked, bytes)
    return checked


def _as_word(value: str) -> Word:
    if isinstance(value, Word):
        return value
    word = Word(value)
    if write(word).startswith('"'):
        raise PropertyError("bad-value", f"expected word, found string {_described(value)}")
    return word


def _marker(value: Element) -> Element:
    if value.name != "marker":
        raise PropertyError("bad-value", f"expected marker, found element {value.name}")
    location = value.find("location")
    if location is None:
        if value.find("polar") is None and value.find("region") is None:
            raise PropertyError("bad-value", "expected a marker with location, polar or region")
    elif not (is_vector(location.leaf) and len(_group(location.leaf or ())) in (2, 3, 6)):
        raise PropertyError("bad-value", "expected a location of 2, 3 or 6 numbers")
    return value


def _described(value: Content) -> str:
    if isinstance(value, bytes):
        return "bytes"
    text = write(value)
    return f"{kind_of(value)} {text if len(text) <= 60 else text[:60] + '…'}"


def from_payload(kind: Type, payload: str | bytes) -> Content:
    """Read what a request carries as a value of a type.

    Raises:
        PropertyError: ``syntax``, ``too-large``, ``bad-value``.
    """
    if kind.base == "number" and isinstance(payload, str):
        number = lone_number(payload)
        if number is not None:
            return number
    if kind.base == "bytes":
        raw = payload if isinstance(payload, bytes) else payload.encode("utf-8", "surrogateescape")
        return _bounded(raw)
    if isinstance(payload, bytes):
        try:
            payload = payload.decode("utf-8")
        except UnicodeDecodeError as error:
            raise PropertyError("syntax", f"{error.start} expected UTF-8") from None
    if kind.base == "text":
        return str(_bounded(payload))
    value = read(payload)
    if kind.base == "string" and not isinstance(value, str | tuple | Element):
        return payload.strip()  # a string need not be quoted where it looks like a number
    return check(kind, value)


def _bounded(payload: bytes | str) -> bytes | str:
    if len(payload) > LIMITS.text:
        raise PropertyError("too-large", f"longer than {LIMITS.text} bytes")
    return payload


def to_payload(kind: Type, value: Content) -> str | bytes:
    """Return what a reply carries for a value of a type.

    Raises:
        PropertyError: ``bad-value``, ``too-large``: no text stands for it.
    """
    if isinstance(value, bytes):
        return value
    return str(value) if kind.base == "text" and isinstance(value, str) else write(value)
