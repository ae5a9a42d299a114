"""Pictures of a scene: what is where the formula says, hidden or lit as it is."""

from __future__ import annotations

import math
import struct
import zlib

import numpy as np
import pytest

from rtkit.errors import Malformed
from rtkit.world import Ball, Polygon, Scene, photo, png

ROOM = Polygon([(-9, -9), (9, -9), (9, 9), (-9, 9)], holes=[[(-4, -4), (4, -4), (4, 4), (-4, 4)]])
RED = (0.9, 0.0, 0.0)


def red_pixels(pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    reds = (pixels[..., 0].astype(int) > 60) & (pixels[..., 1] < 20) & (pixels[..., 2] < 20)
    rows, columns = np.nonzero(reds)
    return rows, columns


@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_a_ball_is_where_the_formula_says(heading: float) -> None:
    ahead, left, up, field = 2.0, 0.4, -0.2, 1.2
    eye = (0.5, -0.3, 0.5, heading)
    cos, sin = math.cos(heading), math.sin(heading)
    centre = (0.5 + cos * ahead - sin * left, -0.3 + sin * ahead + cos * left, 0.5 + up)
    pixels = photo(Scene([ROOM]), eye, [Ball(centre, 0.15, RED)], field=field)
    focus = 160 / math.tan(field / 2)
    rows, columns = red_pixels(pixels)
    assert columns.mean() + 0.5 == pytest.approx(160 - focus * left / ahead, abs=1.0)
    assert rows.mean() + 0.5 == pytest.approx(120 - focus * up / ahead, abs=1.0)
    width = np.ptp(columns) + 1
    assert width == pytest.approx(2 * focus * 0.15 / ahead, rel=0.06)


def test_walls_and_nearer_balls_hide_what_is_behind() -> None:
    ball = Ball((2.0, 0.0, 0.3), 0.2, RED)
    eye = (0.0, 0.0, 0.3, 0.0)
    everything = len(red_pixels(photo(Scene([ROOM]), eye, [ball]))[0])
    screen = Polygon([(1.0, 0.0), (1.1, 0.0), (1.1, 1.0), (1.0, 1.0)])
    half = len(red_pixels(photo(Scene([ROOM, screen]), eye, [ball]))[0])
    assert half == pytest.approx(everything / 2, rel=0.05)
    nearer = Ball((1.0, 0.0, 0.3), 0.2, (0.0, 0.0, 0.9))
    for order in ([ball, nearer], [nearer, ball]):
        assert len(red_pixels(photo(Scene([ROOM]), eye, order))[0]) == 0
    assert len(red_pixels(photo(Scene([ROOM]), (0.0, 0.0, 0.3, math.pi), [ball]))[0]) == 0


def test_in_the_dark_only_what_glows_is_bright() -> None:
    balls = [Ball((2.0, 0.3, 0.3), 0.2, RED), Ball((2.0, -0.5, 1.0), 0.2, (1.0, 1.0, 0.9), True)]
    day, night = (photo(Scene([ROOM]), (0, 0, 0.5, 0.0), balls, light=light) for light in (1, 0.2))
    assert night.mean() < 0.35 * day.mean()
    assert night.max() == day.max() == 255


def test_floor_wall_and_ceiling_meet_where_they_are() -> None:
    pixels = photo(Scene([ROOM]), (0.0, 0.0, 1.0, 0.0), width=200, height=200, field=math.pi / 2)
    column = pixels[:, 100].astype(int)
    edges = np.nonzero(np.abs(np.diff(column.sum(1))) > 20)[0] + 1
    assert list(edges) == [62, 125]  # 1.5 m over the eye and 1 m below it, 4 m ahead


@pytest.mark.parametrize(
    ("width", "height", "field"), [(0, 9, 1), (9, -1, 1), (9, 9, 3.2), (9999, 999, 1)]
)
def test_no_picture_of_no_pixels(width: int, height: int, field: float) -> None:
    with pytest.raises(Malformed, match="no picture"):
        photo(Scene(), (0, 0, 1, 0), width=width, height=height, field=field)


def test_a_png_holds_the_pixels_as_they_are() -> None:
    pixels = photo(Scene([ROOM]), (0.0, 0.0, 1.0, 0.4), width=33, height=21)
    data = png(pixels)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", data[16:24]) == (33, 21)
    at = data.index(b"IDAT")
    (length,) = struct.unpack(">I", data[at - 4 : at])
    rows = np.frombuffer(zlib.decompress(data[at + 4 : at + 4 + length]), np.uint8).reshape(21, 100)
    assert np.array_equal(rows[:, 1:].reshape(21, 33, 3), pixels)
