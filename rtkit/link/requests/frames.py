"""Requests to a manager and replies as frames of bytes, for a unix socket of its host.

========  =============================================================================
frame     size [bytes] of what follows: 4 bytes, little-endian
request   number: 4, is a SET: 1, deadline: 32, size of the name: 4, name, payload
reply     number: 4, size of the kind of the error: 1, that kind, text
========  =============================================================================

Names are those below the key of the manager: ``@/manager.pid``, ``@x/listing``. A connection
begins with `GREETING`, which the manager sends. See decision 99.
"""

from __future__ import annotations

from struct import Struct

from rtkit.errors import Malformed

GREETING = b"rtkit 1\n"
_SIZE = Struct("<I")
_REQUEST = Struct("<I?32sI")
_REPLY = Struct("<IB")
_MOST = 1 << 28
"""How large a frame may be [bytes]."""


def request_frame(number: int, name: str, payload: str | None, deadline: bytes) -> bytes:
    """Return a request, a GET without a payload; its deadline is of `rtkit.link.deadline`."""
    called, sent = name.encode("utf-8", "surrogateescape"), b""
    if payload is not None:
        sent = payload.encode("utf-8", "surrogateescape")
    head = _REQUEST.pack(number, payload is not None, deadline, len(called))
    return _SIZE.pack(len(head) + len(called) + len(sent)) + head + called + sent


def request_of(frame: bytes) -> tuple[int, str, bytes | None, bytes]:
    """Return the number, name, payload and deadline of a request.

    Raises:
        Malformed: It is none.
    """
    if len(frame) < _REQUEST.size:
        raise Malformed("not a request: too short")
    number, is_set, deadline, size = _REQUEST.unpack_from(frame)
    begin = _REQUEST.size + size
    if begin > len(frame):
        raise Malformed("not a request: its name is cut off")
    name = frame[_REQUEST.size : begin].decode("utf-8", "surrogateescape")
    return number, name, frame[begin:] if is_set else None, deadline


def reply_frame(number: int, text: str, kind: str) -> bytes:
    """Return a reply; the kind is that of an error, or empty."""
    body, of_error = text.encode("utf-8", "surrogateescape"), kind.encode()
    head = _REPLY.pack(number, len(of_error))
    return _SIZE.pack(len(head) + len(of_error) + len(body)) + head + of_error + body


def reply_of(frame: bytes) -> tuple[int, str, str]:
    """Return the number, text and kind of a reply.

    Raises:
        Malformed: It is none.
    """
    if len(frame) < _REPLY.size:
        raise Malformed("not a reply: too short")
    number, size = _REPLY.unpack_from(frame)
    begin = _REPLY.size + size
    kind = frame[_REPLY.size : begin].decode("ascii", "replace")
    return number, frame[begin:].decode("utf-8", "surrogateescape"), kind


def take_frame(received: bytearray) -> bytes | None:
    """Take the first whole frame off what was received; None if it is not there yet.

    Raises:
        Malformed: It would be larger than any is.
    """
    if len(received) < _SIZE.size:
        return None
    (size,) = _SIZE.unpack_from(received)
    if size > _MOST:
        raise Malformed(f"a frame of {size} bytes")
    end = _SIZE.size + size
    if len(received) < end:
        return None
    frame = bytes(memoryview(received)[_SIZE.size : end])
    del received[:end]
    return frame
