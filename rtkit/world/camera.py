"""Pictures of a scene through a pinhole: walls of one height, floor, ceiling, and balls."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rtkit.errors import Malformed
from rtkit.world.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Pixels = NDArray[np.uint8]
    Floats = NDArray[np.float64]

Colour = tuple[float, float, float]
_FLOOR, _WALL, _CEILING = (0.45, 0.38, 0.30), (0.82, 0.80, 0.74), (0.93, 0.94, 0.96)
_FAR = 60.0
"""Where no wall is, the horizon is that far [m]."""
_NEAR = 0.01


class Ball(NamedTuple):
    """Ball that stands out of floor and walls.

    Attributes:
        centre: x, y, z [m].
        radius: More than 0 [m].
        colour: Red, green, blue, 0 to 1.
        glows: It is as bright in the dark.
    """

    centre: tuple[float, float, float]
    radius: float
    colour: Colour = (0.8, 0.1, 0.1)
    glows: bool = False


def photo(
    scene: Scene,
    eye: Sequence[float],
    balls: Iterable[Ball] = (),
    *,
    width: int = 320,
    height: int = 240,
    field: float = 1.2,
    light: float = 1.0,
    ceiling: float = 2.5,
) -> Pixels:
    """Return what a level camera sees, as rows of pixels of red, green and blue.

    A point that is `d` ahead of the eye, `l` to its left and `u` above it is at the column
    ``width / 2 - f l / d`` and the row ``height / 2 - f u / d``, with
    ``f = width / 2 / tan(field / 2)``; pixel 0 has its middle at 0.5.

    Args:
        scene: Its walls, and its objects, are as high as the ceiling.
        eye: x, y, z and heading [m, rad].
        balls: What else there is.
        width: Of the picture [pixels].
        height: The same.
        field: Between its left and its right side [rad].
        light: 1 is day, 0 is night.
        ceiling: Its height [m].

    Raises:
        Malformed: The picture has no pixel or more than 4,000,000, or no field below half a turn.
    """
    if not (width > 0 < height and width * height <= 4_000_000 and 0 < field < math.pi):
        raise Malformed(f"no picture of {width} x {height} pixels and {field:g} rad")
    x, y, z, heading = eye
    focus = width / 2 / math.tan(field / 2)
    left: Floats = (width / 2 - np.arange(width, dtype=np.float64) - 0.5) / focus
    up: Floats = ((height / 2 - np.arange(height, dtype=np.float64) - 0.5) / focus)[:, None]
    bearings = np.arctan(left)
    free = scene.rays((x, y), (heading + bearings).tolist(), _FAR)
    depth = np.maximum(free * np.cos(bearings), _NEAR)
    shades = np.broadcast_to(1.0 / (1.0 + 0.08 * depth), (height, width))[..., None]
    pixels = np.where((up * depth < -z)[..., None], _FLOOR, np.array(_WALL) * shades)
    pixels = np.where((up * depth > ceiling - z)[..., None], _CEILING, pixels) * light
    depths = np.where(up * depth < -z, z / np.maximum(-up, 1e-9), depth)
    depths = np.where(up * depth > ceiling - z, (ceiling - z) / np.maximum(up, 1e-9), depths)
    for ball in balls:
        _draw(pixels, depths, ball, (x, y, z, heading), (left, up), light)
    found: Pixels = np.clip(np.rint(pixels * 255), 0, 255).astype(np.uint8)
    return found


def _draw(
    pixels: Floats,
    depths: Floats,
    ball: Ball,
    eye: tuple[float, float, float, float],
    rays: tuple[Floats, Floats],
    light: float,
) -> None:
    """Draw a ball where it is before what is drawn already; each ray is (1, left, up)."""
    away, across, above = (a - b for a, b in zip(ball.centre, eye[:3], strict=True))
    cos, sin = math.cos(eye[3]), math.sin(eye[3])
    centre = np.array((cos * away + sin * across, cos * across - sin * away, above))
    left, up = rays
    square = 1 + left * left + up * up
    along = centre[0] + left * centre[1] + up * centre[2]
    under = along * along - square * (centre @ centre - ball.radius**2)
    with np.errstate(invalid="ignore"):
        met = (along - np.sqrt(under)) / square
    seen = (under >= 0) & (met > _NEAR) & (met < depths)
    rows, columns = np.nonzero(seen)
    at = met[rows, columns]
    upward = (at * up[rows, 0] - centre[2]) / ball.radius
    facing = (centre[0] - at) / ball.radius
    shade = 1.0 if ball.glows else light * (0.55 + 0.25 * upward + 0.2 * facing)
    pixels[rows, columns] = np.array(ball.colour) * np.broadcast_to(shade, at.shape)[:, None]
    depths[rows, columns] = at


def png(pixels: Pixels) -> bytes:
    """Return a picture as a file of the format PNG."""
    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in np.ascontiguousarray(pixels))
    parts = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(rows, 6)),
        (b"IEND", b""),
    )
    chunks = (
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in parts
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
