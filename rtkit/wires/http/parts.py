"""Writes events as parts of ``multipart/x-mixed-replace``, each in place of the one before.

A browser draws such a stream where it is an image: ``<img src="/ps/CAMERA/image?stream">``.
"""

from __future__ import annotations

from rtkit.property.messages import PropertyEvent
from rtkit.wires.http.request import TEXT, HttpRequest, kind_of_bytes

_MULTIPART = "multipart/x-mixed-replace"
_MARK = "rtkit-part"
PARTS = f"{_MULTIPART}; boundary={_MARK}"
"""Media type of a stream of parts."""
BOUNDARY = b"--%b\r\n" % _MARK.encode()


def as_parts(asked: HttpRequest, accepts: str) -> HttpRequest | None:
    """Return what is listened to if a stream of parts is wanted, by ``?stream`` or the header."""
    name, _, parameters = asked.target.partition("?")
    given = [each for each in parameters.split("&") if each]
    options = [each for each in given if each != "stream"]
    if options == given and _MULTIPART not in accepts:
        return None
    return asked._replace(target=f"{name}?{'&'.join(options)}".rstrip("?"))


def write_part(event: PropertyEvent) -> bytes:
    """Return an event as it is sent: its boundary follows at once, so that it is shown at once."""
    if event.code:
        return b""  # the property has gone: the stream ends
    payload, kind = event.payload, TEXT
    if isinstance(payload, bytes):
        kind = kind_of_bytes(payload)
    else:
        payload = payload.encode("utf-8", "surrogateescape")
    head = f"Content-Type: {kind}\r\nContent-Length: {len(payload)}\r\n\r\n".encode()
    return b"%b%b\r\n%b" % (head, payload, BOUNDARY)
