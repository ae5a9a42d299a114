"""Range finder, a sensor in a simulated world: distances along rays, and where they end."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Final

import rtkit
from rtkit.services.frames import Frames
from rtkit.services.sensor import MIDDLE, Pose6, Sensor

if TYPE_CHECKING:
    from rtkit.world import Noise, Scene

HALF_CIRCLE = tuple(math.radians(each) for each in range(-90, 91))


class RangeFinder(Sensor):
    """Laser scanner of a body in a scene; each GET looks at the scene as it is then.

    Args:
        scene: Walls and objects, which may move.
        pose: Returns place and heading of the base in the scene [m, rad].
        bearings: Of the rays, from ahead counter-clockwise [rad].
        reach: How far it sees [m].
        noise: Makes ranges noisy.
        rate: How often a reading is worth while [Hz].
        location, base, frames: See `Sensor`; its location is that of the scanner in the base.

    Attributes:
        bearings: Of the rays, from ahead counter-clockwise [rad].
    """

    type: Final[tuple[str, ...]] = ("rangefinder", "sensor")  # type: ignore[misc]
    unit: Final[str] = "m"  # type: ignore[misc]

    def __init__(
        self,
        scene: Scene,
        pose: Callable[[], Sequence[float]],
        bearings: Sequence[float] = HALF_CIRCLE,
        reach: float = 4.0,
        noise: Noise | None = None,
        rate: float = 10.0,
        location: Pose6 = MIDDLE,
        base: str = "",
        frames: Frames | None = None,
    ) -> None:
        super().__init__(location, base, frames)
        self.bearings: Final[Annotated[tuple[float, ...], rtkit.Unit("rad")]] = tuple(bearings)
        self.range: Final[tuple[float, ...]] = (0.0, reach)  # type: ignore[misc]
        self.rate: Final[Annotated[float, rtkit.Unit("Hz")]] = rate  # type: ignore[misc]
        self._scene, self._pose, self._noise = scene, pose, noise

    def get_ranges(self) -> Annotated[tuple[float, ...], rtkit.Unit("m")]:
        """Distances along the bearings [m]; the reach where nothing is."""
        from rtkit.world import Pose

        base, own, reach = Pose(*self._pose()), self._location, self.range[1]
        heading = base.theta + own[5]
        rays = [heading + each for each in self.bearings]
        found = self._scene.rays(base.of(own[:2]), rays, reach)
        seen = found if self._noise is None else self._noise.on(found, reach)
        return tuple(map(float, seen))

    def get_data(self) -> Annotated[tuple[float, ...], rtkit.Unit("m")]:
        """The ranges [m]."""
        return self.get_ranges()

    def _found(self) -> list[rtkit.Marker]:
        """See `Sensor`: a marker where each ray hits something."""
        return hits(self.bearings, self.get_ranges(), self.range[1])


def hits(bearings: Iterable[float], ranges: Iterable[float], reach: float) -> list[rtkit.Marker]:
    """Return a marker where each ray hits something, in the frame of the sensor [rad, m]."""
    return [
        rtkit.Marker((far * math.cos(bearing), far * math.sin(bearing), 0.0), type="obstacle")
        for bearing, far in zip(bearings, ranges, strict=True)
        if far < reach
    ]
