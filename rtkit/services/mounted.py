"""Sensors that are mounted on a simulated robot: laser, eye for markers, camera."""

from __future__ import annotations

import math
import random
import time
from typing import Annotated, Final, Literal

import rtkit
from rtkit.services import images
from rtkit.services.chassis import Chassis
from rtkit.services.frames import Frames, compose, inverse, plain, transform
from rtkit.services.sensor import MIDDLE, Pose6, Sensor

Metres = rtkit.Unit("m")
_SENSOR = rtkit.Word("sensor")
_HALF_CIRCLE = tuple(math.radians(each) for each in range(-90, 91))


class _Mounted(Sensor):
    """Sensor at a place of the base."""

    def __init__(
        self, chassis: Chassis, frames: Frames, at: Pose6, noise: float = 0.0, seed: int = 0
    ) -> None:
        super().__init__(at, frames=frames)
        self._chassis, self._noise = chassis, noise
        self._random = random.Random(f"{seed} {type(self).__name__}")


class Laser(_Mounted):
    """181 rays from the right to the left, to 4 m.

    Attributes:
        bearings: Of the rays, from ahead counter-clockwise [rad].
    """

    type: Final[tuple[rtkit.Word, ...]] = (rtkit.Word("laser"), _SENSOR)  # type: ignore[misc]
    range: Final[Annotated[tuple[float, ...], Metres]] = (0.0, 4.0)  # type: ignore[misc]
    unit: Final = "m"  # type: ignore[misc]
    bearings: Final[Annotated[tuple[float, ...], rtkit.Unit("rad")]] = _HALF_CIRCLE

    def get_ranges(self) -> Annotated[tuple[float, ...], Metres]:
        """The way that is free along each ray."""
        x, y, *_, heading = self.get_location("world")
        found = self._chassis.world.get_ranges(at=(x, y, heading), reach=self.range[1])
        if not self._noise:
            return tuple(found)
        return tuple(max(0.0, each + self._random.gauss(0.0, self._noise)) for each in found)

    get_data = get_ranges

    def _found(self) -> list[rtkit.Marker]:
        """See `Sensor`: a marker where each ray hits something."""
        return [
            rtkit.Marker((far * math.cos(bearing), far * math.sin(bearing), 0.0), type="obstacle")
            for bearing, far in zip(self.bearings, self.get_ranges(), strict=True)
            if far < self.range[1]
        ]


class Eye(_Mounted):
    """Sees objects ahead of it, within 1.2 rad and 5 m, unless a wall hides them."""

    type: Final[tuple[rtkit.Word, ...]] = (rtkit.Word("eye"), _SENSOR)  # type: ignore[misc]
    range: Final[Annotated[tuple[float, ...], Metres]] = (0.0, 5.0)  # type: ignore[misc]
    unit: Final = "m"  # type: ignore[misc]

    def get_markers(self, frame: str = "base") -> list[rtkit.Marker]:
        """Objects that it sees; the further off, the less sure."""
        place = self.get_location("world")
        seen = self._chassis.world.get_seen(at=(place[0], place[1], place[5]), reach=self.range[1])
        # Both are taken from one pose: the robot moves meanwhile.
        to_frame = (
            compose(inverse(self._frames.pose(frame)), place) if frame != "base" else self._location
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

    type: Final[tuple[rtkit.Word, ...]] = (rtkit.Word("camera"), _SENSOR)  # type: ignore[misc]

    def get_image(
        self,
        width: int = 320,
        height: int = 240,
        field: float = 1.2,
        format: Literal["png", "jpeg"] = "png",
    ) -> bytes:
        """Picture; JPEG takes the extra ``vision``."""
        x, y, z, _, _, heading = self.get_location("world")
        at = (x, y, z, heading)
        found = self._chassis.world.get_image(at=at, width=width, height=height, field=field)
        if format == "jpeg":
            found = images.encode(images.decode(found), format)
        return bytes(found)

    def get_data(self) -> bytes:
        """The picture."""
        return self.get_image()

    def _found(self) -> list[rtkit.Marker]:
        """See `Sensor`: where the camera is."""
        return [rtkit.Marker(MIDDLE, type="camera")]
