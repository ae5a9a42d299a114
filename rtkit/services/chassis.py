"""Chassis: carries a robot through a world, as it is driven, or led by a behaviour."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any

import rtkit
from rtkit.services import driving
from rtkit.services.driving import Row
from rtkit.services.frames import Frames, plain
from rtkit.services.running import Running, Twist

STANDS: Twist = (0.0, 0.0, 0.0)
_GAIN = 3.0
"""How much faster for each metre or radian that is left [1/s]."""
_TURNS_FIRST = 0.5
"""How far off the target may be ahead of who cannot go sideways [rad]."""


class Chassis:
    """Body that goes into any direction; wheels and legs are others.

    Args:
        world: Name of the world service, or a world of this process; "" is an empty plain.
        body: Its name there.
        start: Where it begins: x, y [m] and heading [rad].
        tops: How fast it goes and turns [m/s, rad/s].

    Attributes:
        dimensions: Length, width and height [m].
        pose: Where it is: x, y [m] and heading [rad].
        velocity: How it moves, as its places tell [m/s, rad/s].
        running: The behaviour that was started last.
        trouble: Why the world does not move it; empty while it does.
        world: Where it is, while it is entered.
    """

    dimensions = (0.3, 0.3, 0.3)

    def __init__(
        self,
        world: Any,
        body: str,
        start: tuple[float, float, float],
        tops: tuple[float, float],
    ) -> None:
        self.body = body
        self.pose = start
        self.tops = tops
        self.velocity = STANDS
        self.running: Running | None = None
        self.world: Any = None
        self._in = world
        self._size = max(self.dimensions[:2]) / 2, self.dimensions[2]
        self._driven = self._led = STANDS
        self.trouble = ""
        self._entered = 0
        self._wake: Callable[[], None] = lambda: None

    def enter(self) -> None:
        """Appear in the world, and be moved there from now on; who is there already stays."""
        self._entered += 1
        if self._entered > 1:
            return
        crew = driving.enlist(self, self._in)
        self.world, self._wake = crew.world, crew.wake
        try:
            self._appear()
        except BaseException as error:
            if getattr(error, "code", "") in ("no-service", "timeout"):
                self.lost(error)  # a world that comes later is entered then
                return
            self._entered = 0
            driving.discharge(self, self._in)
            raise

    def leave(self) -> None:
        """Vanish from the world, once for each time that it was entered."""
        self._entered -= 1
        if self._entered:
            return
        self.halt()
        try:
            self.world.bodies.set(self.body, None)
        except rtkit.PropertyError as error:
            if error.code != "no-service":  # a world that has ended has no bodies
                raise
        finally:
            driving.discharge(self, self._in)

    def _appear(self) -> None:
        """Put its body into the world, where it is."""
        (x, y, heading), (radius, height) = self.pose, self._size
        place = (x, y, 0.0, 0.0, 0.0, heading)
        self.world.bodies.set(self.body, rtkit.Marker(place, radius=radius, height=height))

    @property
    def status(self) -> str:
        """Return ``ready``, ``moving``, or ``waiting`` for its world, and why."""
        if self.trouble:
            return f"waiting: {self.trouble}"
        return "ready" if self.velocity == STANDS else "moving"

    @property
    def driven(self) -> Twist:
        """Return how it is to move: as it was told, or as what leads it asks."""
        return self._led if self._is_led else self._driven

    @property
    def _is_led(self) -> bool:
        return self.running is not None and self.running.state == "running"

    def drive(self, twist: Twist) -> None:
        """Move like that from now on; what leads it is stopped, unless it is to stand."""
        if twist != STANDS and self.running is not None:
            self.running.stop()
        self._driven = self.limited(twist)
        self._wake()

    def follow(self, running: Running) -> None:
        """Be led from now on."""
        self._driven = self._led = STANDS
        before, self.running = self.running, running
        if before is not None:
            before.stop()
        self._wake()

    def halt(self) -> None:
        """Be led and driven no longer."""
        self._driven = STANDS
        if self.running is not None:
            self.running.stop()

    def ranges(self, reach: float = 4.0) -> tuple[float, ...]:
        """Return how far it is free to walls along 181 rays from the right to the left [m]."""
        return tuple(self.world.get_ranges(at=self.pose, reach=reach))

    # as it is moved

    def wanted(self, seconds: float) -> Twist | None:
        """Return how it is to move next, None where it stands."""
        running, is_led = self.running, self._is_led
        if running is not None and is_led:
            self._led = self.limited(running.step(seconds) or STANDS)
        possible = self.possible(self.driven, seconds)
        if possible == STANDS and self.is_settled and not self.trouble and not is_led:
            self.velocity = STANDS
            return None
        return possible

    def moved(self, row: Row, seconds: float) -> None:
        """Take where it is now; a world that was begun anew is entered anew."""
        self.trouble = ""
        if not row:
            self._appear()
            return
        before, self.pose = self.pose, (row[0], row[1], row[2])
        dx, dy = self.pose[0] - before[0], self.pose[1] - before[1]
        half = math.remainder(self.pose[2] - before[2], math.tau) / 2
        # It went along an arc: the chord is shorter.
        rate = (half / math.sin(half) if half else 1.0) / seconds
        cos, sin = rate * math.cos(before[2] + half), rate * math.sin(before[2] + half)
        ahead, left, turning = cos * dx + sin * dy, cos * dy - sin * dx, 2 * half / seconds
        self.velocity = plain((ahead, left, turning))  # type: ignore[assignment]
        self.carried(seconds)

    def lost(self, error: BaseException) -> None:
        """Take that the world does not answer."""
        self.trouble = str(error)
        self.velocity = STANDS

    # what other ones do otherwise

    is_settled = True
    """Whether it may stand as it is."""

    def limited(self, twist: Twist) -> Twist:
        """Return what it may be asked of a motion: no faster than it may be."""
        vx, vy, omega = twist
        speed, turning = self.tops
        share = min(1.0, speed / max(math.hypot(vx, vy), 1e-9), turning / max(abs(omega), 1e-9))
        return vx * share, vy * share, omega * share

    def possible(self, twist: Twist, seconds: float) -> Twist:
        """Return what it can do just now of a motion that it may be asked."""
        return self.limited(twist)

    def carried(self, seconds: float) -> None:
        """Have what moves it follow where it went."""

    def actuators(self, frames: Frames) -> dict[str, Any]:
        """Return what moves it, by name, as objects that are served."""
        return {}

    def steer(self, far: float, bearing: float, seconds: float) -> Twist:
        """Return how to go to a point that is so far off, at a bearing [m, rad]."""
        speed = min(self.tops[0], far * _GAIN, far / seconds)
        turn = bearing if far > 2 * self._size[0] else 0.0
        return speed * math.cos(bearing), speed * math.sin(bearing), self.bounded(_GAIN * turn)

    def bounded(self, turning: float) -> float:
        """Return a turning that is no faster than it may be [rad/s]."""
        return max(-self.tops[1], min(self.tops[1], turning))


class Wheels(Chassis):
    """Two wheels that turn on their own: it goes ahead and back, and turns.

    Attributes:
        angles: Of the left and the right wheel [rad].
        speeds: How fast they turn [rad/s].
    """

    track = 0.24
    """Between the wheels [m]."""
    wheel_radius = 0.04

    def __init__(self, *args: Any, **named: Any) -> None:
        super().__init__(*args, **named)
        self.angles = self.speeds = (0.0, 0.0)

    def limited(self, twist: Twist) -> Twist:
        """Return what wheels may be asked: nothing to the side."""
        return super().limited((twist[0], 0.0, twist[2]))

    def carried(self, seconds: float) -> None:
        """Turn the wheels as it went."""
        ahead, _, omega = self.velocity
        half = omega * self.track / 2
        self.speeds = (ahead - half) / self.wheel_radius, (ahead + half) / self.wheel_radius
        left, right = (a + s * seconds for a, s in zip(self.angles, self.speeds, strict=True))
        self.angles = left, right

    def actuators(self, frames: Frames) -> dict[str, Any]:
        """Return its wheels."""
        return {"left": _Wheel(self, 0), "right": _Wheel(self, 1)}

    def steer(self, far: float, bearing: float, seconds: float) -> Twist:
        """Return how to go to a point: first turn to it."""
        if abs(bearing) > _TURNS_FIRST:
            return 0.0, 0.0, self.bounded(_GAIN * bearing)
        speed = min(self.tops[0], far * _GAIN, far / seconds) * math.cos(bearing)
        return speed, 0.0, self.bounded(_GAIN * bearing)


class _Wheel:
    """Wheel that turns as the robot went."""

    def __init__(self, wheels: Wheels, side: int) -> None:
        self._wheels, self._side = wheels, side

    def get_angle(self) -> Annotated[float, rtkit.Unit("rad")]:
        """Angle by which it has turned."""
        return self._wheels.angles[self._side]

    def get_speed(self) -> Annotated[float, rtkit.Unit("rad/s")]:
        """Speed of its turning."""
        return self._wheels.speeds[self._side]
