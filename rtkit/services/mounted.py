"""Sensors that are mounted on a simulated robot: laser, eye for markers, camera."""

from __future__ import annotations

import math
import random
import time
from typing import Annotated, Final, Literal

import rtkit
from rtkit.services import images
from rtkit.services.chassis import Chassis
from rtkit.services.frames import Frames, Pose, compose, inverse, plain, transform

Metres = rtkit.Unit("m")


class _Mounted:
    """Sensor at a place of the base."""

    type: Final[tuple[rtkit.Word, ...]] = (rtkit.Word("sensor"),)

    def __init__(
        self, chassis: Chassis, frames: Frames, at: Pose, noise: float = 0.0, seed: int = 0
    ) -> None:
        self._chassis, self._frames, self._at = chassis, frames, at
        self._noise = noise
        self._random = random.Random(f"{seed} {type(self).__name__}")

    def get_location(
        self, frame: str = "base"
    ) -> Annotated[tuple[float, ...], Metres, rtkit.Concurrent()]:
        """Place where it is mounted: x y z a b c."""
        return self._frames.convert(self._at, "base", frame)

    def _place(self) -> Pose:
        """Return where it is in the world."""
        return self._frames.convert(self._at, "base", "world")


class Laser(_Mounted):
    """181 rays from the right to the left, to 4 m."""

    range: Final[Annotated[tuple[float, float], Metres]] = (0.0, 4.0)
    unit: Final = "m"

    def get_ranges(self) -> Annotated[tuple[float, ...], Metres]:
        """The way that is free along each ray."""
        found = self._chassis.ranges(self.range[1])
        if not self._noise:
            return found
        return tuple(max(0.0, each + self._random.gauss(0.0, self._noise)) for each in found)

    get_data = get_ranges


class Eye(_Mounted):
    """Sees objects ahead of it, within 1.2 rad and 5 m, unless a wall hides them."""

    range: Final[Annotated[tuple[float, float], Metres]] = (0.0, 5.0)

    def get_markers(self, frame: str = "base") -> list[rtkit.Marker]:
        """Objects that it sees; the further off, the less sure."""
        place = self._place()
        seen = self._chassis.world.get_seen(at=(place[0], place[1], place[5]), reach=self.range[1])
        # Both are taken from one pose: the robot moves meanwhile.
        to_frame = (
            compose(inverse(self._frames.pose(frame)), place) if frame != "base" else self._at
        )
        found = []
        for each in seen:
            there = transform(inverse(place), each.location[:3])
            sigma = self._noise * math.hypot(*there)
            noisy = tuple(part + self._random.gauss(0.0, sigma) for part in there)
            found.append(
                each.with_(
                    location=plain(transform(to_frame, noisy)),
                    frame="" if frame == "base" else frame,
                    time=time.time(),
                    variance=sigma * sigma or None,
                )
            )
        return found

    get_data = get_markers


class SimulatedCamera(_Mounted):
    """Pictures of the world as it stands when they are asked for."""

    def get_image(
        self,
        width: int = 320,
        height: int = 240,
        field: float = 1.2,
        format: Literal["png", "jpeg"] = "png",
    ) -> bytes:
        """Picture; JPEG takes the extra ``vision``."""
        x, y, z, _, _, heading = self._place()
        at = (x, y, z, heading)
        found = self._chassis.world.get_image(at=at, width=width, height=height, field=field)
        if format == "jpeg":
            found = images.encode(images.decode(found), format)
        return bytes(found)
