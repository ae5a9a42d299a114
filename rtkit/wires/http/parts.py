"""Writes events as parts of ``multipart/x-mixed-replace``, each in place of the one before.

A browser draws such a stream where it is an image: ``<img src="/ps/CAMERA/image?stream">``.
"""

from __future__ import annotations

from secrets import token_hex

from rtkit.property.messages import PropertyEvent
from rtkit.wires.http.request import TEXT, HttpRequest, kind_of_bytes

_MULTIPART = "multipart/x-mixed-replace"
_MARK = f"rtkit-{token_hex(12)}"  # that nobody can guess, and have in a picture
PARTS = f"{_MULTIPART}; boundary={_MARK}"
"""Media type of a stream of parts."""


def as_parts(asked: HttpRequest, accepts: str) -> HttpRequest | None:
    """Return what is listened to if a stream of parts is wanted, by ``?stream`` or the header."""
    name, _, parameters = asked.target.partition("?")
    given = [each for each in parameters.split("&") if each]
    options = [each for each in given if each != "stream"]
    if options == given and _MULTIPART not in accepts:
        return None
    return asked._replace(target=f"{name}?{'&'.join(options)}".rstrip("?"))


class PartWriter:
    """Writes events as parts. The head of the next part follows each at once.

    Until that has come, Chromium shows the picture before.
    """

    def __init__(self) -> None:
        self._head = b""

    def __call__(self, event: PropertyEvent) -> bytes:
        """Return an event as it is sent."""
        if event.code:
            return b""  # the property has gone: the stream ends
        payload, kind = event.payload, TEXT
        if isinstance(payload, bytes):
            kind = kind_of_bytes(payload)
        else:
            payload = payload.encode("utf-8", "surrogateescape")
        head = f"\r\n--{_MARK}\r\nContent-Type: {kind}\r\n\r\n".encode()
        begins = b"" if head == self._head else head  # an empty part, where the kind changes
        self._head = head
        return begins + payload + head
