"""Pictures in and out: JPEG and PNG, bounded before they are decoded."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

import rtkit
from rtkit.errors import Refused
from rtkit.extras import how_to_get

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Picture = NDArray[np.uint8]
    """Rows of pixels, each blue, green, red."""

MOST_PIXELS = 16_000_000
_PNG = b"\x89PNG\r\n\x1a\n"
_FRAMES_OF_JPEG = frozenset({*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC})
_TO = {"jpeg": ".jpg", "png": ".png"}


def opencv() -> Any:
    """Return the module of OpenCV.

    Raises:
        Refused: It is not there.
    """
    try:
        import cv2
    except ImportError as error:
        raise Refused(f"vision needs OpenCV: {how_to_get('vision')}") from error
    # The sender of a picture is told what is wrong with it.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
    return cv2


def size_of(data: bytes) -> tuple[int, int]:
    """Return width and height of a JPEG or PNG [pixels], which its head tells.

    Raises:
        PropertyError: ``bad-value``: it is neither, or only its beginning.
    """
    if data.startswith(_PNG) and len(data) > 24:
        width, height = struct.unpack(">II", data[16:24])
        return width, height
    at = 2
    while data.startswith(b"\xff\xd8") and at + 9 < len(data) and data[at] == 0xFF:
        kind, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if kind in _FRAMES_OF_JPEG:
            height, width = struct.unpack(">HH", data[at + 5 : at + 9])
            return width, height
        at += 1 if kind == 0xFF else 2 + length
    raise rtkit.PropertyError("bad-value", f"no JPEG or PNG picture: {len(data)} bytes")


def decode(data: bytes) -> Picture:
    """Return the picture that a JPEG or PNG holds.

    Raises:
        PropertyError: ``bad-value``: it is neither, or damaged; ``too-large``.
    """
    cv2 = opencv()
    import numpy as np

    width, height = size_of(data)
    if width * height > MOST_PIXELS:
        raise rtkit.PropertyError(
            "too-large", f"{width} x {height} pixels, more than {MOST_PIXELS // 1_000_000} million"
        )
    ends = data.rfind(b"\xff\xd9", -1024) if data[0] == 0xFF else data.rfind(b"IEND", -1024)
    try:
        raw = np.frombuffer(data, np.uint8)
        found = None if ends < 0 else cv2.imdecode(raw, cv2.IMREAD_COLOR)
    except cv2.error:
        found = None
    if found is None:
        raise rtkit.PropertyError("bad-value", "the picture is damaged, or not whole")
    picture: Picture = found
    return picture


def encode(picture: Picture, format: str, width: int = 0) -> bytes:
    """Return a picture as JPEG or PNG.

    Args:
        picture: Of one channel or three.
        format: ``jpeg`` or ``png``.
        width: To which it is scaled [pixels]; 0 leaves it as it is.

    Raises:
        PropertyError: ``bad-parameter``: there is no such format or width; ``too-large``.
    """
    cv2 = opencv()
    if format not in _TO:
        raise rtkit.PropertyError("bad-parameter", f"format is jpeg or png, not {format}")
    height = round(picture.shape[0] * width / picture.shape[1])
    if width < 0 or width * height > MOST_PIXELS:
        raise rtkit.PropertyError("bad-parameter", f"no width of a picture: {width}")
    if width:
        is_smaller = width < picture.shape[1]
        method = cv2.INTER_AREA if is_smaller else cv2.INTER_LINEAR
        picture = cv2.resize(picture, (width, max(1, height)), interpolation=method)
    _, data = cv2.imencode(_TO[format], picture)
    return bytes(data)
