"""Moves time stamps of recorded values to the present without decoding the values."""

from __future__ import annotations

import struct
import time

from rtkit.recording.entries import NANOSECONDS

_HEADER = 4
_FORMS = {b"\x00\x01": struct.Struct("<II"), b"\x00\x00": struct.Struct(">II")}


def shifted(payload: bytes, stamp_ns: int) -> bytes:
    """Return the value with the present time for its stamp.

    A value that does not begin with the stamp `stamp_ns` [ns] has none and stays as it is.
    """
    form = _FORMS.get(payload[:2])
    if form is None or len(payload) < _HEADER + form.size:
        return payload
    seconds, nanoseconds = form.unpack_from(payload, _HEADER)
    if seconds * NANOSECONDS + nanoseconds != stamp_ns:
        return payload
    changed = bytearray(payload)
    form.pack_into(changed, _HEADER, *divmod(time.time_ns(), NANOSECONDS))
    return bytes(changed)
