"""Requests about blocks of bytes, which the owner of a property takes and joins."""

from __future__ import annotations

from collections.abc import Callable

from rtkit.property.blocks import as_bytes
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Payload
from rtkit.property.property_spec import PropertySpec, RequestParameter
from rtkit.property.types import parse_type
from rtkit.property.values import Value

_INTEGER = parse_type("integer")
_OFFSET = RequestParameter("offset", _INTEGER, None, (), "where a block begins")
OF_GET = {
    "offset": _OFFSET,
    "length": RequestParameter("length", _INTEGER, None, (), "of the block"),
}
OF_SET = {
    "offset": _OFFSET,
    "size": RequestParameter("size", _INTEGER, None, (), "of all blocks together"),
}
_MOST_BEGUN = 8
_LARGEST = 1 << 26


def taken(spec: PropertySpec, given: dict[str, Value]) -> dict[str, int]:
    """Take the parameters of a block that the owner of a property does not take itself.

    Raises:
        PropertyError: ``bad-parameter``: one is negative.
    """
    own = {each.key for each in spec.parameters}
    found: dict[str, int] = {}
    for key in {**OF_GET, **OF_SET}:
        if key in given and key not in own:
            found[key] = int(given.pop(key))  # type: ignore[arg-type]
            if found[key] < 0:
                raise PropertyError("bad-parameter", f"{key} is negative")
    return found


def cut(payload: Payload, block: dict[str, int]) -> bytes:
    """Return a block of bytes; shorter, or empty, where they end."""
    data, offset = as_bytes(payload), block.get("offset", 0)
    return data[offset : offset + block.get("length", len(data))]


class Joining:
    """Joins blocks that are set one after the other; the value changes with the last of them."""

    def __init__(self) -> None:
        self._begun: dict[str, bytearray] = {}

    def put(
        self, name: str, old: Callable[[], Payload], data: bytes, block: dict[str, int]
    ) -> bytes | None:
        """Return what a property is to hold, None while blocks are missing.

        Raises:
            PropertyError: ``conflict``: it is not the next block; ``bad-value``: it lies beyond the
                end; ``too-large``.
        """
        offset, size = block.get("offset", 0), block.get("size")
        end = offset + len(data)
        if end > (_LARGEST if size is None else size) or (size or 0) > _LARGEST:
            raise PropertyError(
                "too-large", f"the block ends at {end}, the whole at {size or _LARGEST}"
            )
        if size is None:
            before = as_bytes(old())
            if offset > len(before):
                raise PropertyError("bad-value", f"there are {len(before)} bytes")
            return before[:offset] + data + before[end:]
        if offset == 0:
            self._begun.pop(name, None)
            if len(self._begun) >= _MOST_BEGUN:
                del self._begun[next(iter(self._begun))]
            self._begun[name] = bytearray()
        begun = self._begun.get(name, bytearray())
        if len(begun) != offset:
            raise PropertyError("conflict", f"the next block begins at {len(begun)}")
        begun += data
        if len(begun) < size:
            return None
        self._begun.pop(name, None)
        return bytes(begun)
