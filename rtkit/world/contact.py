"""First contact of a moving disc or point with edges, solved exactly along its arc.

With ``u = 2 tan(omega t / 2) / omega``, which is ``t`` where nothing turns, the distance of the
centre from a line and its squared distance from a corner are quadratic in ``u``, over the same
denominator ``1 + omega² u² / 4``. So an arc and a straight motion are one case, and nothing is lost
where `omega` is small.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rtkit.world.shapes import Point, Pose, moved

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TOLERANCE = 1e-9
"""How deep a body may be in a wall before that counts as a contact [m]."""
_LONGEST_TURN = math.pi / 2
NO_DISCS = np.zeros((0, 3))
"""Discs in the way, a row each: place of the centre and radius [m]."""


class Contact(NamedTuple):
    """A body has met a wall.

    Attributes:
        time: When, from the beginning of the motion [s].
        normal: The direction away from the wall, of length 1.
        edge: Which edge of the scene was met; -1 for a disc.
    """

    time: float
    normal: Point
    edge: int


class Edges(NamedTuple):
    """The walls as arrays, a row each: the solid is to the left of an edge.

    Attributes:
        begin: First corner [m].
        along: Unit vector to the second one.
        normal: Unit vector to the free side.
        length: From one to the other [m].
    """

    begin: Floats
    along: Floats
    normal: Floats
    length: Floats


def first_contact(
    edges: Edges,
    pose: Pose,
    radius: float,
    twist: tuple[float, float, float],
    dt: float,
    discs: Floats = NO_DISCS,
) -> Contact | None:
    """Return the first contact of a disc, or a point, that moves with a twist [m/s, rad/s].

    What touches already and moves along the wall, or away from it, has none.
    """
    vx, vy, omega = twist
    count = max(1, math.ceil(abs(omega) * dt / _LONGEST_TURN))
    span = dt / count
    for part in range(count):
        start = moved(pose, vx, vy, omega, part * span)
        found = _on_short_arc(edges, start, radius, twist, span, discs)
        if found is not None:
            return found._replace(time=part * span + found.time)
    return None


def _on_short_arc(
    edges: Edges,
    pose: Pose,
    radius: float,
    twist: tuple[float, float, float],
    dt: float,
    discs: Floats,
) -> Contact | None:
    vx, vy, omega = twist
    if abs(omega) * dt < TOLERANCE / 1e3:
        omega = 0.0
    last = dt if not omega else 2 * math.tan(omega * dt / 2) / omega
    cos, sin = math.cos(pose.theta), math.sin(pose.theta)
    v = np.array((cos * vx - sin * vy, sin * vx + cos * vy))
    turned = np.array((-v[1], v[0])) * (omega / 2)
    first, row, normal = math.inf, -1, np.zeros(2)
    if len(edges.length):
        first, row, normal = _first_side(edges, pose, radius, v, turned, omega, last)
    for centres, reach in ((edges.begin, radius), (discs[:, :2], radius + discs[:, 2])):
        if not len(centres) or not np.any(reach):
            continue
        away = (pose.x, pose.y) - centres
        c = (away * away).sum(1) - reach * reach
        a = c * (omega * omega / 4) + 2 * (away @ turned) + v @ v
        u = _entering(a / (2 * reach), (away @ v) / reach, c / (2 * reach), last)
        met = int(u.argmin())
        if u[met] < first:
            row, first = met if centres is edges.begin else -1, float(u[met])
            normal = away[met] + _shift(first, v, turned, omega)
            normal = normal / math.hypot(*normal)
    if not math.isfinite(first):
        return None
    time = first if not omega else 2 * math.atan(omega * first / 2) / omega
    return Contact(min(time, dt), (float(normal[0]), float(normal[1])), row)


def _first_side(
    edges: Edges, pose: Pose, radius: float, v: Floats, turned: Floats, omega: float, last: float
) -> tuple[float, int, Floats]:
    """Return when a side of a wall is met, infinity for never, which, and its normal."""
    away = (pose.x, pose.y) - edges.begin
    height = (away * edges.normal).sum(1)
    c = height - radius
    u = _entering(c * (omega * omega / 4) + edges.normal @ turned, edges.normal @ v, c, last)
    # A wall that the body is behind is not entered where it stands.
    u[(u == 0) & (height < -2 * TOLERANCE)] = np.inf
    # Where the centre is then beside the line of an edge only, a corner is met, or nothing.
    at = np.where(np.isfinite(u), u, 0.0)[:, None]
    place = ((away + _shift(at, v, turned, omega)) * edges.along).sum(1)
    slack = 0.0 if radius else TOLERANCE
    u[(place < -slack) | (place > edges.length + slack)] = np.inf
    row = int(u.argmin())
    return float(u[row]), row, edges.normal[row]


def _shift(u: float | Floats, v: Floats, turned: Floats, omega: float) -> Floats:
    shift: Floats = (v * u + turned * (u * u)) / (1 + omega * omega * u * u / 4)
    return shift


def _entering(a: Floats, b: Floats, c: Floats, last: float) -> Floats:
    """Return where each a u² + b u + c comes down to 0 in [0, last], infinity where it does not.

    What does not get below the tolerance has not come down: rounding must not stop a body that
    slides along a wall. What is below and goes on down does so at 0.
    """
    with np.errstate(all="ignore"):
        lowest = np.minimum(c, (a * last + b) * last + c)
        valley = -b / (2 * a)
        lowest = np.where((a > 0) & (valley > 0) & (valley < last), c + b * valley / 2, lowest)
        under = b * b - 4 * a * c
        root = np.sqrt(np.maximum(under, 0.0))
        u = np.where(b < 0, np.maximum(2 * c / (root - b), 0.0), -(b + root) / (2 * a))
    comes_up = (under >= 0) | (c > -2 * TOLERANCE)
    found: Floats = np.where((lowest < -TOLERANCE) & comes_up & (u >= 0) & (u <= last), u, np.inf)
    return found
