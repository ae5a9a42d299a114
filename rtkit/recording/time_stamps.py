"""Reads and changes the time stamps of values in CDR without decoding the values.

A value that has a time stamp begins with it, behind the header.
"""

from __future__ import annotations

import struct
import time

from rtkit.recording.entries import NANOSECONDS

_HEADER = 4
_FORMS = {b"\x00\x01": struct.Struct("<II"), b"\x00\x00": struct.Struct(">II")}


def stamp_of(payload: bytes | memoryview) -> int | None:
    """Return the time with which a value begins, Unix time [ns]; None if it is too short."""
    form = _FORMS.get(bytes(payload[:2]))
    if form is None or len(payload) < _HEADER + form.size:
        return None
    seconds, nanoseconds = form.unpack_from(payload, _HEADER)
    return int(seconds) * NANOSECONDS + int(nanoseconds)


def shifted(payload: bytes, stamp_ns: int) -> bytes:
    """Return the value with the present time for its stamp.

    A value that does not begin with the stamp `stamp_ns` [ns] has none and stays as it is.
    """
    if stamp_of(payload) != stamp_ns:
        return payload
    changed = bytearray(payload)
    _FORMS[payload[:2]].pack_into(changed, _HEADER, *divmod(time.time_ns(), NANOSECONDS))
    return bytes(changed)
