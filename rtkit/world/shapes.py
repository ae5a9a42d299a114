"""Polygons, poses, and the exact arc of a pose that moves with a constant twist."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from rtkit.errors import Malformed

Point = tuple[float, float]
"""A place in the frame of the world [m]."""
Ring = tuple[Point, ...]
"""The corners of a closed line [m]; the last is joined to the first."""
_STRAIGHT = 1e-4
"""Half of a turn below which its sine is taken from its series [rad]."""


class Pose(NamedTuple):
    """Place and heading in the frame of the world: metres, and radians in (-pi, pi]."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def of(self, point: Sequence[float]) -> Point:
        """Return where a point of this pose's own frame is in the frame of the world [m]."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        x, y = point
        return self.x + cos * x - sin * y, self.y + sin * x + cos * y


def wrapped(angle: float) -> float:
    """Return the same angle in (-pi, pi] [rad]."""
    turned = math.remainder(angle, math.tau)
    return math.pi if turned == -math.pi else turned


def moved(pose: Pose, vx: float, vy: float, omega: float, dt: float) -> Pose:
    """Return the pose after a twist in the body's own frame was held for a while.

    A differential robot has no `vy`. The arc is exact, also where `omega` is next to nothing:
    a motion in two parts leads to where the whole one leads.

    Args:
        pose: Where it begins.
        vx: Speed ahead [m/s].
        vy: Speed to the left [m/s].
        omega: Turning, counter-clockwise [rad/s].
        dt: How long [s].
    """
    half = omega * dt / 2
    chord = dt * (math.sin(half) / half if abs(half) > _STRAIGHT else 1 - half * half / 6)
    cos, sin = math.cos(pose.theta + half), math.sin(pose.theta + half)
    return Pose(
        pose.x + chord * (cos * vx - sin * vy),
        pose.y + chord * (sin * vx + cos * vy),
        wrapped(pose.theta + omega * dt),
    )


@dataclass(frozen=True, slots=True)
class Polygon:
    """Solid area with corners in metres, in either order of turning.

    Args:
        outer: The ring round it.
        holes: Free rooms cut out of it; they do not touch each other nor `outer`.

    Raises:
        Malformed: A ring has fewer than three corners, no area, or a corner that is no place.
    """

    outer: Ring
    holes: tuple[Ring, ...] = ()

    def __init__(
        self,
        outer: Sequence[Sequence[float]],
        holes: Sequence[Sequence[Sequence[float]]] = (),
    ) -> None:
        object.__setattr__(self, "outer", _ring(outer, 1.0))
        object.__setattr__(self, "holes", tuple(_ring(hole, -1.0) for hole in holes))

    @property
    def rings(self) -> tuple[Ring, ...]:
        """All rings; the solid is to the left of each edge."""
        return (self.outer, *self.holes)

    def at(self, pose: Pose) -> Polygon:
        """Return this polygon, drawn in the frame of an object, where the object is at a pose."""
        outer, *holes = (tuple(map(pose.of, ring)) for ring in self.rings)
        return Polygon(outer, holes)


def _ring(corners: Sequence[Sequence[float]], turning: float) -> Ring:
    """Return corners in that order of turning: 1 counter-clockwise, -1 clockwise."""
    try:
        ring = tuple((float(x), float(y)) for x, y in corners)
    except (TypeError, ValueError):
        raise Malformed(f"corners are pairs of numbers, not {corners!r}") from None
    if not all(math.isfinite(x) and math.isfinite(y) for x, y in ring):
        raise Malformed("a corner is not finite")
    ring = tuple(p for i, p in enumerate(ring) if p != ring[i - 1])
    area = sum(ring[i - 1][0] * y - x * ring[i - 1][1] for i, (x, y) in enumerate(ring)) / 2
    if len(ring) < 3 or not area:
        raise Malformed(f"a ring needs three corners that enclose an area, not {list(ring)}")
    return ring if area * turning > 0 else ring[::-1]
