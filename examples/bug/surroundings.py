"""Surroundings: the points of walls that were seen lately, and which ways they leave free.

A disc that rolls along a wall finds the way round it: of all headings, the first one, turned from
the wall away, in which the disc does not meet a point. So corners, tips and rooms are one case.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import asin, atan2, cos, hypot, inf, pi, radians, remainder, sin, tau

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Point = tuple[float, float]
Pose = tuple[float, float, float]

_KEPT = 1.3
"""How far away a point may be that is remembered [m]."""
_UNSURE = 0.14
"""How far beside its bearing a point may be that is remembered [m]."""
_WIDEST = radians(13)
"""For how much on each side of its bearing a range speaks at most."""
_WIDE = radians(5)
_STEEPEST = radians(35)
"""How far from the heading a wall beside the robot may lead."""
_CONTACT = 0.5
"""How far the place of contact may move in one step [m]."""
_OPPOSITE = 0.24
"""How near a wall may come that is not the one that is followed [m]."""
_HEADINGS = np.radians(np.arange(0.0, 357.0, 3.0))


class Surroundings:
    """What is known of the walls near the robot.

    Args:
        safe: How far off the walls the robot shall go [m].

    Attributes:
        has_ranges: Whether its sensors measure ranges.
        is_coarse: Whether a range may be of a place far beside its bearing.
        reach: Longest range seen until now [m].
        beside: Range on the side of the followed wall, where ranges are coarse [m].
        contact: The place of the wall that is followed; None before.
    """

    def __init__(self, safe: float) -> None:
        self.safe = safe
        self.has_ranges = False
        self.is_coarse = False
        self.reach = 0.0
        self.beside = inf
        self.contact: Point | None = None
        self._here = (0.0, 0.0, 0.0)
        self._bearings = self._ranges = self._halves = np.zeros(0)
        self._kept = self._seen = self._guessed = np.zeros((0, 2))
        self._last: tuple[float, float, float, float] | None = None

    def update(self, pose: Pose, scan: Sequence[tuple[float, float]], side: float) -> None:
        """Take in the ranges of one step.

        Args:
            pose: Where the robot is (m, m, rad).
            scan: Bearings [rad] and ranges [m].
            side: 1 while it follows a wall on the right, -1 on the left, else 0.
        """
        self._here = pose
        values = np.array(scan, dtype=np.float64).reshape(-1, 2)
        self.has_ranges = bool(len(values))
        if not self.has_ranges:
            return
        values = values[values[:, 0].argsort(kind="stable")]
        self._bearings, self._ranges = values.T
        gaps = np.diff(self._bearings) / 2
        ends = (gaps[:1], gaps[-1:]) if len(gaps) else (np.array([inf]),) * 2
        around = np.minimum(np.append(ends[0], gaps), np.append(gaps, ends[1]))
        self._halves = np.minimum(around, _WIDEST)
        self.is_coarse = bool(self._halves.max() > _WIDE)
        self.reach = max(self.reach, float(self._ranges.max()))
        echo = self._ranges < self.reach - 1e-6
        self._guessed, self.beside = np.zeros((0, 2)), inf
        angles = self._bearings + pose[2]
        if self.is_coarse and side:
            angles = angles + self._shifts(echo, side)
        places = np.stack((np.cos(angles), np.sin(angles)), 1) * self._ranges[:, None] + pose[:2]
        near = echo & (self._ranges <= np.minimum(_KEPT, _UNSURE / np.sin(self._halves)))
        self._seen = places[echo]
        self._kept = np.concatenate((self._remembered(), places[near]))

    def _shifts(self, echo: NDArray[np.bool_], side: float) -> Floats:
        """Return by how much beside the middle of each cone its place is [rad].

        A range is that of the nearest place in a cone. Of a wall that is followed that is, ahead,
        the side of the cone next to it. What is beside the robot then tells where the wall goes,
        and that is drawn a little further.
        """
        shifts = np.zeros(len(echo))
        beside = int(abs(self._bearings + side * pi / 2).argmin())
        ahead = int(abs(self._bearings).argmin())
        last, self._last = self._last, None
        far = self._ranges[beside]
        self.beside = float(far) if echo[beside] else inf
        if beside == ahead or not echo[beside] or far > 2 * self.safe:
            return shifts
        x, y, theta = self._here
        bearing, front = float(self._bearings[beside]), float(self._ranges[ahead])
        place = np.array((far * cos(bearing), far * sin(bearing)))  # in the frame of the robot
        off, length = 0.0, 0.14
        if echo[ahead] and front > 0.38:
            shifts[ahead] = -side * self._halves[ahead]
            edge = float(self._bearings[ahead] + shifts[ahead])
            along = np.array((front * cos(edge), front * sin(edge))) - place
            closing = side * atan2(along[1], along[0])  # one that recedes may be another wall
            if 0 < closing < _STEEPEST:
                off, length = side * closing, 0.28
        if not off and last is not None:
            back = np.array(
                (
                    cos(theta) * (last[0] - x) + sin(theta) * (last[1] - y),
                    cos(theta) * (last[1] - y) - sin(theta) * (last[0] - x),
                )
            )
            along = place - back
            is_moved = hypot(last[2] - x, last[3] - y) > 0.08
            if is_moved and hypot(*along) < 0.35:
                off = max(-_STEEPEST, min(_STEEPEST, atan2(along[1], along[0])))
        half = self._halves[beside]
        shifts[beside] = max(-half, min(half, off))
        bearing += float(shifts[beside])
        place = np.array((far * cos(bearing), far * sin(bearing)))
        turn = np.array(((cos(theta), -sin(theta)), (sin(theta), cos(theta))))
        along = np.array((cos(off), sin(off)))
        steps = np.arange(0.07, length + 0.01, 0.07)[:, None]
        self._guessed = (place + along * steps) @ turn.T + (x, y)
        self._last = (*(turn @ place + (x, y)), x, y)
        return shifts

    def _remembered(self) -> Floats:
        """Return the earlier points that are near and not in sight again."""
        away = self._kept - self._here[:2]
        far = np.hypot(away[:, 0], away[:, 1])
        bearings = np.arctan2(away[:, 1], away[:, 0]) - self._here[2]
        bearings = (bearings + pi) % tau - pi
        at = np.searchsorted(self._bearings, bearings).clip(1, max(1, len(self._bearings) - 1))
        if len(self._bearings) > 1:
            left = abs(bearings - self._bearings[at - 1])
            at = np.where(left < abs(bearings - self._bearings[at]), at - 1, at)
        else:
            at = np.zeros_like(at)
        inside = abs(bearings - self._bearings[at]) <= self._halves[at] + 1e-9
        again = inside & (far < self._ranges[at] + 0.05)
        return self._kept[(far < _KEPT) & ~again]

    def touch(self, bearing: float, radius: float) -> None:
        """Take in that something is felt at a bearing [rad] and a distance [m]."""
        x, y, theta = self._here
        self.contact = (x + radius * cos(theta + bearing), y + radius * sin(theta + bearing))

    def sees(self, bearing: float) -> bool:
        """Return whether a bearing of the robot's frame is in the field of view [rad]."""
        return bool((abs(self._bearings - bearing) <= self._halves + 1e-9).any())

    def free(self, bearing: float, width: float) -> float:
        """Return how far a way of some width to each side [m] is free of all known points [m]."""
        found = float(self.all_free(np.array([bearing]), width)[0])
        at = int(abs(self._bearings - bearing).argmin())
        if abs(self._bearings[at] - bearing) <= self._halves[at]:
            found = min(found, float(self._ranges[at]))
        return found

    def all_free(self, bearings: Floats, width: float) -> Floats:
        """Return that for several bearings of the robot's frame [rad]; at most the reach [m]."""
        points = np.concatenate((self._seen, self._kept)) - self._here[:2]
        if not len(points):
            return np.full(bearings.shape, self.reach)
        angles = bearings + self._here[2]
        x, y = np.cos(angles)[:, None], np.sin(angles)[:, None]
        ahead = x * points[:, 0] + y * points[:, 1]
        beside = abs(x * points[:, 1] - y * points[:, 0])
        found: Floats = np.where((beside < width) & (ahead > 0), ahead, self.reach).min(1)
        return found

    def ends(self) -> list[tuple[float, float, float]]:
        """Return bearing [rad], range [m] and side of the ends of each run of beams.

        The side is 1 where the run is to the right of its end, -1 where it is to the left.
        """
        found = []
        echo = self._ranges < self.reach - 1e-6
        for at in np.flatnonzero(echo):
            for other, side in ((at - 1, -1.0), (at + 1, 1.0)):
                if not 0 <= other < len(echo):
                    continue
                is_end = not echo[other] or self._ranges[other] > self._ranges[at] + 2 * self.safe
                if is_end:
                    bearing = float(self._bearings[at] + side * self._halves[at])
                    found.append((bearing, float(self._ranges[at]), side))
        return found

    def slope(self, bearing: float) -> float | None:
        """Return how far from a bearing the nearest place seen in front of it lies [rad]."""
        away = self._seen - self._here[:2]
        if not len(away):
            return None
        off = np.arctan2(away[:, 1], away[:, 0]) - self._here[2] - bearing
        off = (off + pi) % tau - pi
        far = np.where(abs(off) < pi / 2, np.hypot(away[:, 0], away[:, 1]), inf)
        return float(off[int(far.argmin())])

    def find_contact(self, bearing: float | None = None) -> Point | None:
        """Return the place of the followed wall that is nearest now [m].

        Args:
            bearing: Where a new wall was met, in the robot's frame [rad]; None: the same wall.
        """
        x, y, theta = self._here
        points = np.concatenate((self._kept, self._guessed))
        away = points - (x, y)
        far = np.hypot(away[:, 0], away[:, 1])
        if bearing is not None:
            off = np.arctan2(away[:, 1], away[:, 0]) - theta - bearing
            fits = abs((off + pi) % tau - pi) < pi / 3
            place = (x + 0.4 * cos(theta + bearing), y + 0.4 * sin(theta + bearing))
            self.contact = place
        elif self.contact is not None:
            near = points - self.contact
            fits = np.hypot(near[:, 0], near[:, 1]) < _CONTACT
        else:
            return None
        if fits.any():
            at = int(np.where(fits, far, inf).argmin())
            self.contact = (float(points[at, 0]), float(points[at, 1]))
        return self.contact

    def roll(self, side: float, step: float) -> float:
        """Return the bearing in which the disc rolls on along the followed wall [rad].

        Args:
            side: 1 with the wall on the right, -1 with it on the left.
            step: How far it is to go [m].
        """
        contact = self.contact or (self._here[0], self._here[1])
        first = atan2((contact[1] - self._here[1]) * side, contact[0] - self._here[0])
        headings = first + _HEADINGS
        free = self._fits(headings, side, step, first)
        turned = headings[int(free.argmax())] if free.any() else first + 2 * pi / 3
        return remainder(turned * side - self._here[2], tau)

    def steer(self, aim: float, step: float) -> float | None:
        """Return the bearing next to one that is aimed at [rad] in which nothing is near."""
        base = aim + self._here[2]
        offs = np.radians([0.0, *(s * each for each in range(4, 181, 4) for s in (1, -1))])
        free = self._fits(base + offs, 1.0, step, None)
        return remainder(aim + float(offs[int(free.argmax())]), tau) if free.any() else None

    def _fits(
        self, headings: Floats, side: float, step: float, contact: float | None
    ) -> NDArray[np.bool_]:
        """Return for which headings (mirrored where the wall is on the left) a step is free."""
        points = np.concatenate((self._kept, self._guessed)) - self._here[:2]
        if self.contact is not None and contact is not None:
            points = np.append(points, [np.subtract(self.contact, self._here[:2])], 0)
        points[:, 1] *= side
        far = np.hypot(points[:, 0], points[:, 1])
        points, far = points[far < self.safe + step + 0.06], far[far < self.safe + step + 0.06]
        wanted = np.full(far.shape, self.safe - 0.01)
        if contact is not None:
            off = (np.arctan2(points[:, 1], points[:, 0]) - contact) % tau
            wanted[(off > radians(110)) & (off < radians(290))] = _OPPOSITE
        else:
            wanted -= 0.03
        end = np.minimum(wanted, far + 0.02)  # what is too near must come to be less so
        middle = np.minimum(wanted - 0.03, far + 0.005)
        ways = np.stack((np.cos(headings), np.sin(headings)), 1)[:, None, :] * step
        fits: NDArray[np.bool_] = np.ones(len(headings), dtype=bool)
        for part, least in ((1.0, end), (0.5, middle)):
            gap = points[None] - ways * part
            fits &= ((gap * gap).sum(2) >= least * least).all(1)
        return fits


def tangent_offset(width: float, far: float) -> float:
    """Return by how much to aim beside a corner to pass it at a distance [rad]."""
    return asin(min(1.0, width / max(far, width)))
