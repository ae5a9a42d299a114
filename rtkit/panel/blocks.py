"""Draws a picture as blocks of colour: two pixels a character."""

from __future__ import annotations

from typing import Any

Line = list[tuple[str, str]]


def blocks(data: bytes, columns: int) -> list[Line]:
    """Return the lines of a JPEG or PNG in so many columns; a sentence where there is no reader."""
    from rtkit.property.codes import PropertyError
    from rtkit.services.images import decode

    try:
        import cv2

        found = decode(data)
    except ImportError:
        from rtkit.extras import how_to_get

        return [[(f"{len(data)} bytes; to see it: {how_to_get('vision')}", "dim")]]
    except PropertyError as error:
        return [[(str(error), "dim")]]
    height, width = found.shape[:2]
    rows = max(1, min(20, round(columns * height / width / 2)))
    small = cv2.resize(found, (columns, 2 * rows), interpolation=cv2.INTER_AREA)
    return [[("▀", f"{_hex(upper)} on {_hex(lower)}") for upper, lower in zip(*pair, strict=True)]
            for pair in zip(small[::2], small[1::2], strict=True)]  # fmt: skip


def _hex(pixel: Any) -> str:
    blue, green, red = (int(each) for each in pixel)
    return f"#{red:02x}{green:02x}{blue:02x}"
