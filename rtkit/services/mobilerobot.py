"""Mobile robot service: simulated robots that are driven by velocity, or led by behaviours."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, Final, Literal, Self
from uuid import uuid4

import rtkit
from rtkit.services.asking import Asking
from rtkit.services.behaviors import MoveTo, behaviors_of, loaded
from rtkit.services.chassis import Chassis, Wheels
from rtkit.services.frames import ORIGIN, Frames, plain, transform
from rtkit.services.mounted import Eye, Laser, SimulatedCamera
from rtkit.services.sensor import MIDDLE, Pose6, numbers, within

_NAME = re.compile(r"(?!(?:properties|parameters|gui|listen|meta|history)$)[\w+~-]+", re.ASCII)
"""Names that a part may bear: those of properties that end in none of the reserved words."""


class MobileRobot(Asking):
    """Mobile robot that goes into any direction; with wheels and legs it is another one.

    Args:
        world: Name of the world service, or a world of this process; none: an empty plain.
        body: Name of its body there; none: one that nobody else has.
        start: Where it begins: x, y [m] and heading [rad].
        top_speed: How fast it goes [m/s].
        top_turning: How fast it turns [rad/s].
        behaviors: Further behaviours: ``name=module:Class …``.
        noise: Standard deviation of what laser and eye measure; of the eye for each metre [m].
        seed: The same seed makes the same noise.
        resource: Name of the service that keeps named frames.

    Attributes:
        actuators: Services that move it, by name.
        sensors: Services that it perceives with, by name.
        behaviors: Its behaviours: `moveto` and others.
    """

    type: Final = ("mobilerobot",)
    version: Final = "1.0"
    chassis_type = Chassis

    def __init__(
        self,
        *,
        world: Any = "",
        body: str = "",
        start: tuple[float, float, float] = (0.0, 0.0, 0.0),
        top_speed: float = 0.5,
        top_turning: float = 1.5,
        behaviors: str = "",
        noise: float = 0.0,
        seed: int = 0,
        resource: str = "resource",
    ) -> None:
        super().__init__(resource)
        body = body or f"body{uuid4().hex[:12]}"  # processes of two hosts may have one id
        x, y, theta = numbers("start", start, 3)
        tops = within("top_speed", top_speed, 1e-6), within("top_turning", top_turning, 1e-6)
        within("noise", noise, 0)
        self._chassis = chassis = self.chassis_type(world, body, (x, y, theta), tops)
        self._frames = frames = Frames(self._pose_of, self.get_location)
        self.actuators: dict[str, Any] = chassis.actuators(frames)
        head = (0.1, 0.0, chassis.dimensions[2], 0.0, 0.0, 0.0)
        self.sensors: dict[str, Any] = {
            "laser": Laser(chassis, frames, MIDDLE, noise, seed),
            "eye": Eye(chassis, frames, head, noise, seed),
            "camera": SimulatedCamera(chassis, frames, head),
        }
        kinds = {"moveto": MoveTo, **loaded(behaviors)}
        self.behaviors: Final = behaviors_of(chassis, frames, kinds)

    def __enter__(self) -> Self:
        self._chassis.enter()
        return self

    def __exit__(self, *raised: object) -> None:
        self._chassis.leave()
        super().__exit__(*raised)

    def get_status(self) -> str:
        """State: ready, moving, or waiting for its world and why."""
        return self._chassis.status

    def get_dimensions(self) -> Annotated[tuple[float, float, float], rtkit.Unit("m")]:
        """Length, width and height."""
        return self._chassis.dimensions

    def get_location(
        self, frame: str = "world"
    ) -> Annotated[Pose6, rtkit.Unit("m"), rtkit.Concurrent()]:
        """Pose: x y z a b c."""
        x, y, theta = self._chassis.pose
        return self._frames.convert((x, y, 0.0, 0.0, 0.0, theta), "world", frame)  # type: ignore[return-value]

    def get_velocity(
        self, frame: str = "base"
    ) -> Annotated[Pose6, rtkit.Unit("m/s"), rtkit.Returns(after=0.5, to=ORIGIN)]:
        """Motion asked of it, by a SET or a behaviour; a SET ends behaviours, and soon itself."""
        return self._turned(self._chassis.driven, "base", frame)

    def set_velocity(self, velocity: Pose6, frame: str = "base") -> None:
        """Drive."""
        vx, vy, *_, omega = velocity
        if not all(map(math.isfinite, velocity)):  # its place would be none for ever after
            raise rtkit.PropertyError("bad-value", f"a velocity has finite numbers, not {velocity}")
        ahead, left, *_ = self._turned((vx, vy, omega), frame, "base")
        self._chassis.drive((ahead, left, omega))

    def get_motion(self, frame: str = "base") -> Annotated[Pose6, rtkit.Unit("m/s")]:
        """Motion as it is: x y z a b c, each a second."""
        return self._turned(self._chassis.velocity, "base", frame)

    def _turned(self, twist: tuple[float, float, float], frame: str, to: str) -> Pose6:
        between = self._frames.between(frame, to) if frame != to else ORIGIN
        x, y, z = transform((0.0, 0.0, 0.0, *between[3:]), (*twist[:2], 0.0))
        return plain((x, y, z, 0.0, 0.0, twist[2]))  # type: ignore[return-value]

    def plug(self, kind: Literal["actuators", "sensors"], name: str, target: str) -> None:
        """Show a service as an actuator or a sensor of this robot: its properties are there."""
        parts = getattr(self, kind)
        if not _NAME.fullmatch(name):
            raise rtkit.PropertyError("bad-value", f"no name of an actuator or a sensor: {name!r}")
        if name in parts:
            raise rtkit.PropertyError("conflict", f"there is one already: {kind}.{name}")
        try:
            self._asked().get(f"{target}.properties")
        except rtkit.PropertyError as error:
            if error.code != "bad-value":  # of an address that only mounts take
                raise
        parts[name] = rtkit.Mount(target)

    def unplug(self, kind: Literal["actuators", "sensors"], name: str) -> None:
        """Show a sensor or an actuator no longer."""
        if getattr(self, kind).pop(name, None) is None:
            raise rtkit.PropertyError("unknown", f"there is none: {kind}.{name}")


class DifferentialRobot(MobileRobot):
    """Mobile robot with two driven wheels: it goes ahead, back, and turns."""

    chassis_type = Wheels


DifferentialRobotInit = rtkit.init_of(DifferentialRobot)
