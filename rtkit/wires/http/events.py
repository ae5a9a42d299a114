"""Writes and reads events as ``text/event-stream`` carries them.

The value is the data; what comes with it (revision, time, quality …) is the id, which a browser
gives to the page as ``lastEventId`` and back to the endpoint when it reconnects. What the stream
cannot carry is base64: bytes in an event of type ``base64``, texts with carriage returns in one of
type ``base64-text``. The last event of a property that has been removed is of type ``end``.

A stream of several properties tells of bytes only how many they are now, in an event of type
``bytes``, and of what cannot be listened to why, in one of type ``refused``.
"""

from __future__ import annotations

from base64 import b64encode

from rtkit.property.line import read_event, write_named
from rtkit.property.messages import PropertyEvent


def write_refused(name: str, why: str) -> bytes:
    """Return what tells that a property of several cannot be listened to."""
    text = " ".join(why.split()).encode("utf-8", "replace")
    return b"id: name=%b\nevent: refused\ndata: %b\n\n" % (name.encode(), text)


def write_sse(event: PropertyEvent, *, has_bytes: bool = True) -> bytes:
    """Return an event as it is sent; with or without the content of bytes."""
    head = f"id: {write_named(event)}\n".encode()
    payload = event.payload
    if event.code:
        return b"%bevent: end\ndata: %b\n\n" % (head, event.code.encode())
    if isinstance(payload, bytes) and not has_bytes:
        return b"%bevent: bytes\ndata: %d\n\n" % (head, len(payload))
    if isinstance(payload, bytes) or "\r" in payload:
        raw = payload if isinstance(payload, bytes) else payload.encode("utf-8", "surrogateescape")
        kind = b"base64" if isinstance(payload, bytes) else b"base64-text"
        return b"%bevent: %b\ndata: %b\n\n" % (head, kind, b64encode(raw))
    raw = payload.encode("utf-8", "surrogateescape")
    return b"%bdata: %b\n\n" % (head, raw.replace(b"\n", b"\ndata: "))


class SseProgress:
    """Last event that a client has received, so that it gets none twice when it reconnects.

    Args:
        id: As `write_sse` made it; anything else has heard nothing.
    """

    def __init__(self, id: str) -> None:
        from rtkit.property.codes import PropertyError

        self._last: tuple[int, float, str] | None = None
        if id:
            try:
                event = read_event("", "", id)
            except PropertyError:
                return  # another's id: everything is new
            self._last = (event.revision, event.time, event.quality)

    def is_new(self, event: PropertyEvent) -> bool:
        """Return whether an event differs from the last one; only the first may repeat it."""
        last, self._last = self._last, None
        return last != (event.revision, event.time, event.quality) or bool(event.code)
