"""Legged robot: six legs, three of which carry the body while the others swing.

The body goes only as far as all feet on the ground can reach, and these stay where they are: so
nothing slips. Joint angles follow from where feet and body are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any

import rtkit
from rtkit.services.chassis import STANDS, Chassis
from rtkit.services.frames import Frames, plain
from rtkit.services.mobilerobot import MobileRobot
from rtkit.services.running import Twist
from rtkit.world import Pose, moved

Point = tuple[float, float, float]
COXA, FEMUR, TIBIA = 0.03, 0.07, 0.11
"""Lengths of the parts of a leg [m]."""
HIP = 0.08
"""Height of the hips over the ground [m]."""
_OUT = 0.12
"""How far from its hip a foot stands at rest [m]."""
_YAW = 1.0
"""How far a hip turns to either side [rad]."""
_LIFT, _SWING_S = 0.03, 0.3
_FASTEST = 0.25
"""Of a foot on the ground against the body [m/s]."""
_REST = 1e-4


@dataclass(frozen=True)
class Leg:
    """Leg, as it is built: hip in the base, and where it points at rest [m, rad]."""

    name: str
    x: float
    y: float
    out: float
    tripod: int

    @property
    def rest(self) -> Point:
        """The place of its foot in the base when the robot stands [m]."""
        return self.x + _OUT * math.cos(self.out), self.y + _OUT * math.sin(self.out), -HIP


LEGS = (
    Leg("left_front", 0.12, 0.08, 0.8, 0),
    Leg("left_middle", 0.0, 0.10, math.pi / 2, 1),
    Leg("left_rear", -0.12, 0.08, 2.3, 0),
    Leg("right_front", 0.12, -0.08, -0.8, 1),
    Leg("right_middle", 0.0, -0.10, -math.pi / 2, 0),
    Leg("right_rear", -0.12, -0.08, -2.3, 1),
)


def joints(leg: Leg, foot: Point) -> Point | None:
    """Return the angles of hip, femur and tibia that put a foot at a place of the base [m, rad].

    None where it cannot get there.
    """
    dx, dy, z = foot[0] - leg.x, foot[1] - leg.y, foot[2]
    yaw = math.remainder(math.atan2(dy, dx) - leg.out, math.tau)
    out = math.hypot(dx, dy) - COXA
    far = math.hypot(out, z)
    if abs(yaw) > _YAW or not abs(FEMUR - TIBIA) < far < FEMUR + TIBIA:
        return None
    inner = math.acos((FEMUR**2 + far**2 - TIBIA**2) / (2 * FEMUR * far))
    knee = math.acos((FEMUR**2 + TIBIA**2 - far**2) / (2 * FEMUR * TIBIA))
    return yaw, math.atan2(z, out) + inner, knee - math.pi


@dataclass(frozen=True)
class Foot:
    """Foot in the world.

    Attributes:
        at: Its place [m].
        is_down: It stands on the ground, and stays there.
        lifted_at: Where it left the ground [m].
    """

    at: Point
    is_down: bool = True
    lifted_at: Point = (0.0, 0.0, 0.0)


class Legs(Chassis):
    """Six legs that walk with three of them at a time on the ground.

    Attributes:
        feet: One for each of `LEGS`.
    """

    dimensions = (0.4, 0.4, 0.12)

    def __init__(self, *args: Any, **named: Any) -> None:
        super().__init__(*args, **named)
        self._twist = STANDS
        self._phase = 0.0
        self._next = 0
        self.feet = tuple(Foot(self._of(leg.rest)) for leg in LEGS)

    def limited(self, twist: Twist) -> Twist:
        """Return what legs may be asked: no foot goes faster against the body than it may."""
        vx, vy, omega = super().limited(twist)
        foot_speed = math.hypot(vx, vy) + abs(omega) * math.hypot(*LEGS[0].rest[:2])
        share = min(1.0, _FASTEST / max(foot_speed, 1e-9))
        return vx * share, vy * share, omega * share

    def possible(self, twist: Twist, seconds: float) -> Twist:
        """Return how far the feet on the ground let the body go."""
        (vx, vy, omega), share = self.limited(twist), 1.0
        for _ in range(8):
            self._twist = (vx * share, vy * share, omega * share)
            there = moved(Pose(*self.pose), *self._twist, seconds)
            if all(
                self._reaches(leg, foot, there) for leg, foot in zip(LEGS, self.feet, strict=True)
            ):
                return self._twist
            share *= 0.5
        self._twist = STANDS
        return STANDS

    @property
    def is_settled(self) -> bool:  # type: ignore[override]
        """Return whether all feet are on the ground, at rest."""
        return all(foot.is_down for foot in self.feet) and not self._off()

    def carried(self, seconds: float) -> None:
        """Lift, swing and put down the feet that do not carry the body."""
        if all(foot.is_down for foot in self.feet):
            if self._twist == STANDS and not self._off():
                return
            self._phase = 0.0
            self.feet = tuple(
                Foot(foot.at, False, foot.at) if leg.tripod == self._next else foot
                for leg, foot in zip(LEGS, self.feet, strict=True)
            )
            self._next = 1 - self._next
        self._phase = min(1.0, self._phase + seconds / _SWING_S)
        self.feet = tuple(
            foot if foot.is_down else self._swung(leg, foot)
            for leg, foot in zip(LEGS, self.feet, strict=True)
        )

    def actuators(self, frames: Frames) -> dict[str, Any]:
        """Return its legs."""
        return {leg.name: _LegActuator(self, frames, n) for n, leg in enumerate(LEGS)}

    def _swung(self, leg: Leg, foot: Foot) -> Foot:
        """Return a foot on its way to where it will be at rest in the midst of its stance."""
        x, y, z = leg.rest
        landing = self._of((*moved(Pose(), *self._twist, _SWING_S / 2).of((x, y)), z))
        if self._phase >= 1.0:
            return Foot(landing)
        ahead = zip(foot.lifted_at, landing, strict=True)
        x, y, z = (a + (b - a) * self._phase for a, b in ahead)
        return replace(foot, at=(x, y, z + _LIFT * math.sin(math.pi * self._phase)))

    def _off(self) -> bool:
        """Return whether a foot is elsewhere than at rest."""
        rests = (self._of(leg.rest) for leg in LEGS)
        return any(math.dist(f.at, r) > _REST for f, r in zip(self.feet, rests, strict=True))

    def _reaches(self, leg: Leg, foot: Foot, pose: Pose) -> bool:
        return not foot.is_down or joints(leg, in_base(foot.at, pose)) is not None

    def _of(self, place: Point) -> Point:
        """Return a place of the base in the world; the ground is at 0 [m]."""
        x, y = Pose(*self.pose).of(place[:2])
        return x, y, place[2] + HIP


def in_base(place: Point, pose: tuple[float, ...]) -> Point:
    """Return a place of the world in the base of a robot [m]; hips are at 0."""
    dx, dy = place[0] - pose[0], place[1] - pose[1]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return cos * dx + sin * dy, cos * dy - sin * dx, place[2] - HIP


class _LegActuator:
    """Leg with three joints."""

    def __init__(self, legs: Legs, frames: Frames, index: int) -> None:
        self._legs, self._frames, self._index = legs, frames, index

    def _angle(self, joint: int) -> float:
        foot = in_base(self._legs.feet[self._index].at, self._legs.pose)
        angles = joints(LEGS[self._index], foot)
        if angles is None:
            raise rtkit.PropertyError("conflict", "the foot is out of reach")
        return plain(angles)[joint]

    def get_phase(self) -> rtkit.Word:
        """State of its foot: stance while it carries the body, or swing."""
        return rtkit.Word("stance" if self._legs.feet[self._index].is_down else "swing")

    def get_foot(self, frame: str = "base") -> Annotated[tuple[float, ...], rtkit.Unit("m")]:
        """Place of its foot, the ground at 0."""
        return self._frames.convert(self._legs.feet[self._index].at, "world", frame)

    def get_coxa(self) -> Annotated[float, rtkit.Unit("rad")]:
        """Angle of the hip against its rest."""
        return self._angle(0)

    def get_femur(self) -> Annotated[float, rtkit.Unit("rad")]:
        """Angle of the femur over the horizon."""
        return self._angle(1)

    def get_tibia(self) -> Annotated[float, rtkit.Unit("rad")]:
        """Angle of the tibia against the femur."""
        return self._angle(2)


class LeggedRobot(MobileRobot):
    """Mobile robot with six legs: it goes into any direction, and turns."""

    chassis_type = Legs


LeggedRobotInit = rtkit.init_of(LeggedRobot)
