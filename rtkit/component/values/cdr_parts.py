"""Functions to which code that writes and reads CDR refers."""

from __future__ import annotations

import struct
from typing import Any

from rtkit.component.values.type_layout import as_items, as_octets, as_truth
from rtkit.errors import Malformed

Octets = bytes | memoryview


def _fits(data: Octets, at: int, count: int, size: int) -> None:
    if count > (len(data) - at) // size:
        raise Malformed(f"{count} items of {size} bytes do not fit into {len(data)} bytes")


def _truth(value: int) -> bool:
    if value > 1:
        raise Malformed(f"not a truth value: {value}")
    return value == 1


def _member(members: dict[int, Any], value: int) -> Any:
    if value not in members:
        raise Malformed(f"not a member of the enumeration: {value}")
    return members[value]


def _unit(value: int) -> int:
    if 0xD800 <= value < 0xE000:
        raise Malformed(f"half of a surrogate pair: {value:#x}")
    return value


def _octets(data: Octets, at: int, length: int) -> bytes:
    if length > len(data) - at:
        raise Malformed(f"{length} bytes do not fit into {len(data)} bytes")
    return bytes(data[at : at + length])


def _text(data: Octets, at: int, length: int) -> str:
    if not length:
        return ""
    found = _octets(data, at, length)
    if found.find(0) != length - 1:
        raise Malformed("a string does not end with its first NUL")
    return found[:-1].decode()


HELPERS: dict[str, object] = {
    "_as_items": as_items,
    "_as_octets": as_octets,
    "_as_truth": as_truth,
    "_fits": _fits,
    "_member": _member,
    "_octets": _octets,
    "_pack": struct.pack,
    "_padding": [bytes(count) for count in range(8)],
    "_text": _text,
    "_truth": _truth,
    "_unit": _unit,
    "_unpack": struct.unpack_from,
}
"""Objects to which the written code refers by name."""
