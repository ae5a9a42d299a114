"""Hardware abstractions of the navigator, each made of the raw values of one sensor set-up.

A navigator asks these ten questions and never reads a raw value. Lengths are metres, angles radians
counter-clockwise, bearings in the frame of the robot (0 is ahead).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, inf, pi, radians, sin
from typing import Protocol

SAFE_DISTANCE = 0.30
STOP_DISTANCE = 0.45
LASER_REACH, INFRA_RED_REACH = 4.0, 2.0
LASER_BEARINGS = tuple(radians(each) for each in range(-90, 91))
INFRA_RED_BEARINGS = (0.0, pi / 2, -pi / 2)
INFRA_RED_WIDTH = radians(26)
BUMPER_BEARINGS = tuple(radians(each) for each in (0, 60, 120, 180, -120, -60))
_BODY = 0.20
"""Half of the width that must be free for the robot to go ahead."""
_SLACK = 0.02

Scan = Sequence[tuple[float, float]]
"""Pairs of bearing and range; a range at the sensor's reach means that nothing is there."""


class Senses(Protocol):
    """What a navigator may ask; adaptors implement it, each for its sensors."""

    def position(self) -> tuple[float, float]:
        """Return where the robot is."""

    def heading(self) -> float:
        """Return where it looks."""

    def safe_distance(self) -> float:
        """Return how far off the walls it shall go."""

    def obstacle_in_front_of_the_robot(self) -> bool:
        """Return whether it must not go on ahead."""

    def obstacle_on_the_left(self) -> bool:
        """Return whether a wall is within reach of following, on the left."""

    def obstacle_on_the_right(self) -> bool:
        """Return whether a wall is within reach of following, on the right."""

    def left_distance(self) -> float:
        """Return the range to the left."""

    def right_distance(self) -> float:
        """Return the range to the right."""

    def free_distance(self, bearing: float) -> float | None:
        """Return the range along a bearing; None outside of the field of view."""

    def scan(self) -> Scan:
        """Return all ranges, empty where the sensors measure none."""


@dataclass(frozen=True, slots=True)
class Located:
    """Place and heading, from odometry: the half that all set-ups share."""

    pose: tuple[float, float, float]

    def position(self) -> tuple[float, float]:
        """Return where the robot is."""
        return self.pose[0], self.pose[1]

    def heading(self) -> float:
        """Return where it looks."""
        return self.pose[2]

    def safe_distance(self) -> float:
        """Return how far off the walls it shall go."""
        return SAFE_DISTANCE


@dataclass(frozen=True, slots=True)
class _Ranging(Located):
    """What is the same for all sensors that measure ranges."""

    def obstacle_in_front_of_the_robot(self) -> bool:
        """Return whether something is ahead within the stop distance, as wide as the body."""
        near = STOP_DISTANCE + _SLACK
        return any(r <= near and abs(r * sin(b)) < _BODY and r * cos(b) > 0 for b, r in self.scan())

    def obstacle_on_the_left(self) -> bool:
        """Return whether a wall is within twice the safe distance, on the left."""
        return self.left_distance() < 2 * SAFE_DISTANCE

    def obstacle_on_the_right(self) -> bool:
        """Return whether a wall is within twice the safe distance, on the right."""
        return self.right_distance() < 2 * SAFE_DISTANCE

    def left_distance(self) -> float:
        """Return the range to the left."""
        found = self.free_distance(pi / 2)
        return inf if found is None else found

    def right_distance(self) -> float:
        """Return the range to the right."""
        found = self.free_distance(-pi / 2)
        return inf if found is None else found


@dataclass(frozen=True, slots=True)
class LaserSenses(_Ranging):
    """Made of 181 ranges, one a degree from the right to the left, 0.02 to 4 m."""

    ranges: Sequence[float]

    def free_distance(self, bearing: float) -> float | None:
        """Return the range of the beam next to a bearing."""
        at = round((bearing + pi / 2) * 180 / pi)
        return self.ranges[at] if 0 <= at < len(self.ranges) else None

    def scan(self) -> Scan:
        """Return all beams."""
        return tuple(zip(LASER_BEARINGS, self.ranges, strict=True))


@dataclass(frozen=True, slots=True)
class InfraRedSenses(_Ranging):
    """Made of three ranges, ahead, left and right: the nearest in a cone of 26 degrees, to 2 m."""

    ranges: Sequence[float]

    def free_distance(self, bearing: float) -> float | None:
        """Return the range of the cone that a bearing is in."""
        for middle, found in self.scan():
            if abs(bearing - middle) <= INFRA_RED_WIDTH / 2:
                return found
        return None

    def scan(self) -> Scan:
        """Return the three ranges at the middles of their cones."""
        return tuple(zip(INFRA_RED_BEARINGS, self.ranges, strict=True))


@dataclass(frozen=True, slots=True)
class CombinedSenses(_Ranging):
    """Made of both: beams where they are, shortened to what a cone found nearer than all of its."""

    ranges: Sequence[float]
    infra_red: Sequence[float]

    def free_distance(self, bearing: float) -> float | None:
        """Return the shorter range of beam and cone, or that of the one that sees there."""
        seen = (
            LaserSenses(self.pose, self.ranges).free_distance(bearing),
            InfraRedSenses(self.pose, self.infra_red).free_distance(bearing),
        )
        found = [each for each in seen if each is not None]
        return min(found) if found else None

    def scan(self) -> Scan:
        """Return the beams; what a cone alone has seen is put at its middle."""
        beams = list(LaserSenses(self.pose, self.ranges).scan())
        for middle, found in InfraRedSenses(self.pose, self.infra_red).scan():
            half = INFRA_RED_WIDTH / 2
            inside = [at for at, (b, _) in enumerate(beams) if abs(b - middle) <= half]
            if found < min(beams[at][1] for at in inside) - _SLACK:
                at = min(inside, key=lambda each: abs(beams[each][0] - middle))
                beams[at] = (beams[at][0], found)
        return beams


@dataclass(frozen=True, slots=True)
class BumperSenses(Located):
    """Made of six switches of 60 degrees, the first one ahead, then counter-clockwise."""

    closed: Sequence[bool]

    def obstacle_in_front_of_the_robot(self) -> bool:
        """Return whether one of the three switches ahead is closed."""
        return bool(self.closed[0] or self.closed[1] or self.closed[5])

    def obstacle_on_the_left(self) -> bool:
        """Return whether one of the two switches on the left is closed."""
        return bool(self.closed[1] or self.closed[2])

    def obstacle_on_the_right(self) -> bool:
        """Return whether one of the two switches on the right is closed."""
        return bool(self.closed[5] or self.closed[4])

    def left_distance(self) -> float:
        """Return 0 where it touches, else infinity."""
        return 0.0 if self.obstacle_on_the_left() else inf

    def right_distance(self) -> float:
        """Return 0 where it touches, else infinity."""
        return 0.0 if self.obstacle_on_the_right() else inf

    def free_distance(self, bearing: float) -> float | None:
        """Return 0 towards a closed switch, else None: nothing is measured."""
        return 0.0 if self.closed[round(bearing / (pi / 3)) % 6] else None

    def scan(self) -> Scan:
        """Return nothing."""
        return ()
