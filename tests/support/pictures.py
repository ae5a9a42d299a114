"""Renders pictures with known truth: polygons, balls and fiducials as a pinhole camera sees them.

A camera's frame has x ahead, y to the left and z up, as that of any sensor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from rtkit.services.frames import inverse, transform

SCALE = 4
"""How many times finer is drawn than shown, so that edges are smooth."""
Picture = NDArray[np.uint8]
WIDTH, HEIGHT, FIELD = 640, 480, 1.2
FOCAL = WIDTH / 2 / math.tan(FIELD / 2)


def canvas(color: Sequence[int] = (200, 200, 200)) -> Picture:
    return np.full((HEIGHT * SCALE, WIDTH * SCALE, 3), color, np.uint8)


def shown(fine: Picture, *, noise: float = 0.0, blur: float = 0.0, seed: int = 1) -> Picture:
    """Return a fine canvas as a camera shows it, out of focus [px] and noisy [grey levels]."""
    picture = cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    if blur:
        picture = cv2.GaussianBlur(picture, (0, 0), blur)
    if noise:
        grain = np.random.default_rng(seed).normal(0, noise, picture.shape)
        picture = np.clip(picture + grain, 0, 255).astype(np.uint8)
    return picture


def _fine(points: Sequence[Sequence[float]]) -> NDArray[np.float64]:
    """Return places of the shown picture, whose first pixel is at (0, 0), as fine ones."""
    return (np.array(points, np.float64) + 0.5) * SCALE - 0.5


def polygon(fine: Picture, corners: Sequence[Sequence[float]], color: Sequence[int]) -> None:
    fixed = np.round(_fine(corners) * 256).astype(np.int32)
    cv2.fillPoly(fine, [fixed], tuple(color), cv2.LINE_AA, 8)


def disc(fine: Picture, center: Sequence[float], radius: float, color: Sequence[int]) -> None:
    turns = np.linspace(0, math.tau, 200)
    rim = np.stack((np.cos(turns), np.sin(turns)), 1) * radius + np.array(center)
    polygon(fine, rim.tolist(), color)


def projected(camera: Sequence[float], place: Sequence[float]) -> tuple[float, float]:
    """Return where a camera sees a place of the world [px]."""
    ahead, left, up = transform(inverse(camera), place)
    return (
        (WIDTH - 1) / 2 - FOCAL * left / ahead,
        (HEIGHT - 1) / 2 - FOCAL * up / ahead,
    )  # fmt: skip


def fiducial(
    fine: Picture, camera: Sequence[float], pose: Sequence[float], id: int, size: float
) -> None:
    """Draw a fiducial with a white margin: its x is to its right, y up, z out of the plate."""
    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    cells, cell = 8, 60  # 6 of the mark, 1 of margin on each side
    texture = np.full((cells * cell, cells * cell, 3), 255, np.uint8)
    mark = cv2.aruco.generateImageMarker(words, id, 6 * cell)
    texture[cell:-cell, cell:-cell] = mark[:, :, None]
    half = size / 2 * cells / 6
    places = [(-half, half), (half, half), (half, -half), (-half, -half)]
    seen = [projected(camera, transform(pose, (x, y, 0.0))) for x, y in places]
    end = cells * cell
    source = np.array([(0, 0), (end, 0), (end, end), (0, end)], np.float32) - 0.5
    target = _fine(seen).astype(np.float32)
    matrix = cv2.getPerspectiveTransform(source, target)
    extent = fine.shape[1], fine.shape[0]
    drawn = cv2.warpPerspective(texture, matrix, extent, flags=cv2.INTER_AREA)
    mask = cv2.warpPerspective(np.full(texture.shape[:2], 255, np.uint8), matrix, extent)
    fine[mask > 127] = drawn[mask > 127]


def ball(
    fine: Picture,
    camera: Sequence[float],
    center: Sequence[float],
    radius: float,
    color: Sequence[int],
) -> None:
    """Draw a ball: its outline is where rays touch it."""
    middle = np.array(transform(inverse(camera), center))
    far = float(np.linalg.norm(middle))
    axis = middle / far
    side = np.cross(axis, (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side)
    up = np.cross(side, axis)
    angle = math.asin(radius / far)
    rim = [
        axis * math.cos(angle) + (side * math.cos(t) + up * math.sin(t)) * math.sin(angle)
        for t in np.linspace(0, math.tau, 200)
    ]
    polygon(
        fine,
        [((WIDTH - 1) / 2 - FOCAL * y / x, (HEIGHT - 1) / 2 - FOCAL * z / x) for x, y, z in rim],
        color,
    )
