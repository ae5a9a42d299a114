"""Bytes in blocks, where they are more than one request carries: how clients ask for them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rtkit.property.limits import LIMITS
from rtkit.property.messages import Payload


def joined_blocks(get: Callable[[dict[str, int]], Payload]) -> bytes:
    """Return the bytes that `get` returns block by block, given the parameters of each request."""
    data = bytearray()
    while True:
        block = as_bytes(get({"offset": len(data), "length": LIMITS.text}))
        data += block
        if len(block) < LIMITS.text:
            return bytes(data)


def blocks_of(data: bytes) -> Iterator[tuple[dict[str, int], bytes]]:
    """Yield the parameters of each request that sets a block, and the block; of few bytes none."""
    if len(data) <= LIMITS.text:
        yield {}, data
        return
    for offset in range(0, len(data), LIMITS.text):
        yield {"offset": offset, "size": len(data)}, data[offset : offset + LIMITS.text]


def as_bytes(payload: Payload) -> bytes:
    """Return what a payload is, whatever it looks like."""
    return payload if isinstance(payload, bytes) else payload.encode("utf-8", "surrogateescape")
