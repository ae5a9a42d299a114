"""Messages between a client of a gateway and the process that reads or writes ports for it.

A frame is the length of its body, an id, and its kind: the number of a word in a request, and in an
answer whether it went well. Values are in CDR.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Iterable, Iterator, Sequence

WORDS = ("open", "join", "extend", "write", "flush", "lost", "take", "call")
OPEN, JOIN, EXTEND, WRITE, FLUSH, LOST, TAKE, CALL = range(len(WORDS))
FAILED, DONE = 0, 1
ENDED, GOES_ON = b"\x01", b"\x00"
"""First byte of arrivals: whether nothing can come any more."""

_HEAD = struct.Struct("<IIB")
_VALUE = struct.Struct("<HqI")
_LARGEST = 1 << 26

Value = tuple[int, int, bytes]
"""The number of its stream, a time [ns], and the value."""


def frame(number: int, kind: int, body: bytes) -> bytes:
    """Return a frame."""
    return _HEAD.pack(len(body), number, kind) + body


class FrameSplitter:
    """Splits bytes into frames."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> Iterator[tuple[int, int, bytes]]:
        """Take bytes, and yield the id, kind and body of each frame that is whole.

        Raises:
            ValueError: One is too large.
        """
        self._buffer += data
        while len(self._buffer) >= _HEAD.size:
            length, number, kind = _HEAD.unpack_from(self._buffer)
            if length > _LARGEST:
                raise ValueError(f"a frame of {length} bytes")
            end = _HEAD.size + length
            if len(self._buffer) < end:
                return
            body = bytes(self._buffer[_HEAD.size : end])
            del self._buffer[:end]
            yield number, kind, body


def call_to_bytes(end: Sequence[str], timeout_s: float, call: bytes) -> bytes:
    """Return a call of a service port as bytes.

    Args:
        end: Instance, port and path of the provider.
        timeout_s: How long to wait for the reply [s].
        call: As `rtkit.component.services.invocation` encodes it, without a deadline.
    """
    return json.dumps([list(end), timeout_s]).encode() + b"\n" + call


def call_from_bytes(data: bytes) -> tuple[list[str], float, bytes]:
    """Return what `call_to_bytes` was given.

    Raises:
        ValueError: It is none of that.
    """
    head, _, call = data.partition(b"\n")
    try:
        (instance, port, typed), timeout_s = json.loads(head)
        bound_s = float(timeout_s)
    except (TypeError, RecursionError) as error:
        raise ValueError(f"no call: {error}") from error
    if not 0 < bound_s < math.inf or not call:
        raise ValueError("no call")
    return [str(instance), str(port), str(typed)], bound_s, call


def values_to_bytes(values: Iterable[Value]) -> bytes:
    """Return values as bytes."""
    parts = []
    for stream, time_ns, payload in values:
        parts += [_VALUE.pack(stream, time_ns, len(payload)), payload]
    return b"".join(parts)


def values_from_bytes(data: bytes) -> Iterator[Value]:
    """Yield what `values_to_bytes` was given.

    Raises:
        ValueError: It is none of that.
    """
    at = 0
    while at < len(data):
        try:
            stream, time_ns, length = _VALUE.unpack_from(data, at)
        except struct.error as error:
            raise ValueError("a value is cut off") from error
        at += _VALUE.size + length
        if at > len(data):
            raise ValueError("a value is cut off")
        yield stream, time_ns, data[at - length : at]
