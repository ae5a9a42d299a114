"""Noise of sensors and odometry, the same for the same seed on every host."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable

from rtkit.errors import Malformed
from rtkit.world.shapes import Pose, wrapped


class Noise:
    """Gaussian noise on ranges.

    Args:
        sigma: Standard deviation [m]; 0 changes nothing.
        seed: The same seed gives the same noise.

    Raises:
        Malformed: `sigma` is below 0.
    """

    def __init__(self, sigma: float, seed: int = 0) -> None:
        self._sigma = _sigma(sigma)
        self._random = random.Random(seed)

    def on(self, ranges: Iterable[float], reach: float) -> list[float]:
        """Return ranges with noise, from 0 to `reach` [m]; one at `reach` had no echo and stays."""
        gauss, sigma = self._random.gauss, self._sigma
        pairs = [(float(each), gauss(0.0, 1.0)) for each in ranges]  # as many for any world
        return [
            each if each >= reach else min(max(each + sigma * by, 0.0), reach) for each, by in pairs
        ]


class Odometry:
    """Estimate that a robot has of its pose: its motions added up, each with a little noise.

    The errors grow with the root of the way, however finely it is divided.

    Args:
        pose: Where it begins; it knows that exactly.
        travel: Error of the length of the way [m per root of a metre].
        turn: Error of the heading by turning [rad per root of a radian].
        drift: Error of the heading by driving [rad per root of a metre].
        seed: The same seed gives the same errors.

    Raises:
        Malformed: One of the errors is below 0.
    """

    def __init__(
        self,
        pose: Pose,
        travel: float = 0.0,
        turn: float = 0.0,
        drift: float = 0.0,
        seed: int = 0,
    ) -> None:
        self.pose = Pose(*pose)
        self._true = self.pose
        self._errors = (_sigma(travel), _sigma(turn), _sigma(drift))
        self._random = random.Random(seed)

    def follow(self, true: Pose) -> Pose:
        """Return what it takes for its pose, after the robot has moved to a true one."""
        travel, turn, drift = self._errors
        gauss, before = self._random.gauss, self._true
        self._true = Pose(*true)
        if not any(self._errors):
            self.pose = self._true
            return self.pose
        dx, dy = true[0] - before.x, true[1] - before.y
        way, turned = math.hypot(dx, dy), wrapped(true[2] - before.theta)
        length = way + travel * math.sqrt(way) * gauss(0.0, 1.0)
        angle = math.sqrt(turn * turn * abs(turned) + drift * drift * way) * gauss(0.0, 1.0)
        x, y, theta = self.pose
        bearing = theta + math.atan2(dy, dx) - before.theta + angle / 2
        self.pose = Pose(
            x + length * math.cos(bearing),
            y + length * math.sin(bearing),
            wrapped(theta + turned + angle),
        )
        return self.pose


def _sigma(value: float) -> float:
    if not 0 <= value < math.inf:
        raise Malformed(f"a standard deviation is 0 or more, not {value:g}")
    return value
