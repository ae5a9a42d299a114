"""Operations: what assemblies choose from, each a function of the navigator under its word."""

from __future__ import annotations

from math import atan2, cos, hypot, inf, pi, radians, remainder, sin, tau
from typing import TYPE_CHECKING

import numpy as np

from . import assembly as words
from .surroundings import tangent_offset

if TYPE_CHECKING:
    from collections.abc import Callable

    from .algorithm import Command, Navigator

Point = tuple[float, float]
_LOOK_AHEAD = 1.0
STOP_AHEAD = 0.45
"""How far before a wall the robot stops [m]."""
_NEARER = 0.03
_FALLING = radians(86)
_ROUND = 1.4 * pi
"""More than the half turn to the other side of a thin wall, or of a narrow corridor [rad]."""
_SEEN = np.radians(np.arange(-90.0, 91.0, 3.0))


class Circuit:
    """The way along one boundary since a point of it: never a clock, only places and turning.

    Args:
        begin: Where it begins: the hit point [m].
    """

    def __init__(self, begin: Point) -> None:
        self.begin = begin
        self.farthest = 0.0
        self.length = 0.0
        self.turning = 0.0
        self.nearest = (inf, begin, 0.0)
        self.is_complete = False
        self._last = begin
        self._course: float | None = None
        self._closest = inf
        self._passed = inf
        self._not_before = 0.0

    def add(self, here: Point, to_goal: float) -> None:
        """Take in the place of a step, and how far the goal is from it [m]."""
        dx, dy = here[0] - self._last[0], here[1] - self._last[1]
        moved = hypot(dx, dy)
        if to_goal < self.nearest[0] - _NEARER:
            self.nearest = (to_goal, here, self.length + moved)
        far = hypot(here[0] - self.begin[0], here[1] - self.begin[1])
        self.farthest = max(self.farthest, far)
        if moved < 0.02:
            return
        course = atan2(dy, dx)
        if self._course is not None:
            self.turning += remainder(course - self._course, tau)
        if self.farthest > 0.25:  # before, it may still be turning along the wall
            self._course = course
        self._last = here
        self.length += moved
        if self.farthest > 0.6 and far <= 0.40 and abs(self.turning) >= _ROUND:
            # Next to the beginning is not there: what lies before it may be the leave point.
            self._passed = min(self._passed, far)
        self.is_complete = self.is_complete or self._passed <= 0.15 or far > self._passed

    def has_returned(self, here: Point) -> bool:
        """Return whether it has come back to its beginning after a turn-round."""
        far = hypot(here[0] - self.begin[0], here[1] - self.begin[1])
        self._closest = min(self._closest, far)
        return far <= 0.15 or (self._closest <= 0.40 and far > self._closest + 0.02)

    def is_shorter_back(self) -> bool:
        """Return whether the nearest point is nearer against the way that was gone."""
        return self.length - self.nearest[2] < self.nearest[2]

    def go_to_nearest(self) -> None:
        """Begin the way to the nearest point."""
        self._closest = inf
        rest = min(self.nearest[2], self.length - self.nearest[2])
        self._not_before = self.length + 0.85 * rest - 0.5  # what is near before is another side

    def is_at_nearest(self, here: Point) -> bool:
        """Return whether this is the nearest point, or where it was just passed."""
        if self.length < self._not_before:
            return False
        x, y = self.nearest[1]
        far = hypot(here[0] - x, here[1] - y)
        self._closest = min(self._closest, far)
        return far <= 0.12 or (self._closest <= 0.40 and far > self._closest)

    def has_passed(self, here: Point) -> bool:
        """Return whether the nearest point lies well behind."""
        x, y = self.nearest[1]
        return hypot(here[0] - x, here[1] - y) > 0.5


class Least:
    """The least distances to the goal that a leave point is held against [m]."""

    def __init__(self) -> None:
        self.ever = self.on_line = self.at_hit = self.since_hit = inf
        self.in_vain = 0

    def hit(self, to_goal: float, on_line: bool) -> None:
        """Take in a hit point."""
        self.in_vain += to_goal > self.since_hit - 0.05
        self.at_hit = to_goal  # a leave that led nowhere is no progress: since_hit stays
        self.pass_by(to_goal, on_line)

    def leave(self, to_goal: float) -> None:
        """Take in a leave point."""
        self.pass_by(to_goal, True)

    def pass_by(self, to_goal: float, on_line: bool) -> None:
        """Take in any place."""
        self.ever = min(self.ever, to_goal)
        self.since_hit = min(self.since_hit, to_goal)
        if on_line:
            self.on_line = min(self.on_line, to_goal)

    def of(self, word: str) -> float:
        """Return the one that a word of ``nearer_than`` names."""
        return {
            words.HIT: self.at_hit,
            words.LINE_POINTS: self.on_line,
            words.ALL_POINTS: self.ever,
            words.SINCE_HIT: self.since_hit,
            words.NOTHING: inf,
        }[word]


# Motions to the goal: the bearing to go to, or None at a hit point.


def go_straight(navigator: Navigator, aim: float | None = None) -> float | None:
    """Aim at the goal, or at a bearing [rad], until something is in front."""
    navigator.least.pass_by(navigator.to_goal, False)
    aim = navigator.bearing if aim is None else aim
    if navigator.is_facing(aim) and navigator.obstacle_in_front_of_the_robot():
        return None
    return aim


def go_along_line(navigator: Navigator) -> float | None:
    """Aim at the m-line a little further on, until something is in front."""
    navigator.least.pass_by(navigator.to_goal, True)
    (sx, sy), (gx, gy) = navigator.start, navigator.goal
    length = hypot(gx - sx, gy - sy) or 1.0
    at = min(navigator.along_line(navigator.here) + _LOOK_AHEAD, length) / length
    x, y = sx + at * (gx - sx), sy + at * (gy - sy)
    aim = remainder(atan2(y - navigator.y, x - navigator.x) - navigator.theta, tau)
    if navigator.is_facing(aim) and navigator.obstacle_in_front_of_the_robot():
        return None
    return aim


def go_by_tangents(navigator: Navigator) -> float | None:
    """Aim at the node of the local tangent graph with the shortest way, until none gets nearer."""
    around = navigator.around
    if not around.has_ranges or around.is_coarse:  # no tangent is known: it acts as by contact
        place = _seen_place(navigator)
        return go_straight(navigator, navigator.bearing if place is None else place)
    if navigator.to_goal < navigator.least.ever - 0.02:
        navigator.stale = 0
    navigator.least.pass_by(navigator.to_goal, False)
    navigator.stale += 1
    if navigator.stale > 40:
        return None
    if abs(navigator.bearing) > pi / 2:
        return navigator.bearing
    aim = _seen_place(navigator)
    if aim is None:
        aim = _tangent(navigator)
    aim = None if aim is None else around.steer(aim, navigator.step)
    if aim is None:
        return None
    off = remainder(aim - navigator.bearing, tau)
    if abs(off) > 0.02:
        navigator.slid = "left" if off > 0 else "right"
    return None if abs(off) > _FALLING else aim


def _seen_place(navigator: Navigator) -> float | None:
    """Return the bearing of the place that made it leave, until it is as near to the goal."""
    if navigator.aimed_at is None:
        return None
    x, y = navigator.aimed_at
    if hypot(x - navigator.x, y - navigator.y) < 0.15:
        navigator.aimed_at = None
        return None
    return remainder(atan2(y - navigator.y, x - navigator.x) - navigator.theta, tau)


def _tangent(navigator: Navigator) -> float | None:
    """Return the bearing of the best node; None where none is nearer than the robot."""
    around, aim = navigator.around, navigator.bearing
    if around.free(aim, 0.25) >= min(navigator.to_goal, around.reach - 1e-6):
        return aim
    found = []
    for bearing, far, side in around.ends():
        towards = bearing + side * tangent_offset(around.safe + 0.05, far)
        off = abs(remainder(towards - aim, tau))
        if off < pi / 2:
            rest = third_side(far, navigator.to_goal, off)
            found.append((far + rest, towards))
    return min(found)[1] if found else aim


def third_side(a: float, b: float, angle: float) -> float:
    """Return the third side of a triangle with two sides [m] and the angle between them [rad]."""
    return float(max(a * a + b * b - 2 * a * b * cos(angle), 0.0) ** 0.5)


# Leave rules: set `leave_point`, or return the command that it takes to see.


def leave_anywhere(navigator: Navigator) -> Command | None:
    """Leave where what counts is nearer to the goal than what it is held against."""
    return NEARNESS[navigator.assembly.by](navigator)


def leave_on_line(navigator: Navigator) -> Command | None:
    """Leave on the m-line, nearer to the goal than what that is held against, if it is free."""
    off, was = navigator.off_line(navigator.here), navigator.was_off
    on_line = abs(off) <= 0.10 or was * off < 0
    found = leave_by_free_way(navigator, True) if on_line else None
    if found is None:
        navigator.was_off, navigator.trial = off, None
    return found


def leave_at_nearest(navigator: Navigator) -> Command | None:
    """Leave at the nearest point of the whole boundary, once that is known."""
    if navigator.circuit.is_complete:
        navigator.leave_point = navigator.circuit.nearest[1]
    return None


def leave_by_free_way(navigator: Navigator, on_line: bool = False) -> Command | None:
    """Leave where the robot itself is nearer, and the way to the goal is free."""
    found: bool | Command | None = False
    if navigator.to_goal < navigator.least.of(navigator.assembly.nearer_than) - 1e-3:
        found = navigator.way_to_goal_is_free()
    return _decided(navigator, found, on_line)


def leave_by_free_range(navigator: Navigator) -> Command | None:
    """Leave where the goal is in sight, or what is free towards it leads nearer by the gain."""
    least = navigator.least.of(navigator.assembly.nearer_than)
    if not navigator.around.has_ranges:  # a wall that is felt, not ranged: F is 0
        least = navigator.least.at_hit
    wanted = least - navigator.assembly.gain
    found: bool | Command | None = False
    if navigator.to_goal - navigator.around.reach <= max(wanted, 0.0):
        found = navigator.way_to_goal_is_free()
    if found is True and navigator.around.has_ranges:
        room = navigator.free_range()  # to a wall: it stops before
        rest = navigator.to_goal - room
        found = rest <= 0 or rest + navigator.around.safe <= wanted
    elif found is True:
        found = navigator.to_goal <= wanted
    return _decided(navigator, found, False)


def leave_by_visible_points(navigator: Navigator) -> Command | None:
    """Leave for a place in sight that is nearer than what it is held against, by the gain."""
    around = navigator.around
    if not around.has_ranges:
        return leave_by_free_way(navigator)
    least = navigator.least.of(navigator.assembly.nearer_than)
    bearings = np.append([b for b in _SEEN if around.sees(float(b))], navigator.bearing)
    room = around.all_free(bearings, around.safe - 0.03) - STOP_AHEAD
    if not around.sees(navigator.bearing):
        bearings, room = bearings[:-1], room[:-1]
    off = bearings - navigator.bearing
    ways = np.clip(navigator.to_goal * np.cos(off), 0.0, np.maximum(room, 0.0))
    far = np.hypot(navigator.to_goal - ways * np.cos(off), ways * np.sin(off))
    best = int(far.argmin())
    # What was seen and could not be reached makes it ask for more.
    wanted = min(navigator.assembly.gain * (1 + navigator.least.in_vain), 0.6 * least)
    found = bool(far[best] < least - wanted)
    if not found and navigator.to_goal < least and around.sees(navigator.bearing):
        navigator.way_to_goal_is_free()  # it notes a narrow place
    if found:
        angle = navigator.theta + float(bearings[best])
        x, y = navigator.here
        length = float(ways[best])
        navigator.aimed_at = (x + length * cos(angle), y + length * sin(angle))
    return _decided(navigator, found, False)


def _decided(navigator: Navigator, found: bool | Command | None, on_line: bool) -> Command | None:
    """Note what was found at this place; a command means that it is not known yet."""
    if isinstance(found, tuple):
        return found
    if found:
        navigator.leave_point = navigator.here
    navigator.trial = None
    if found is None:  # it was looked at from too near to look again
        return None
    navigator.least.pass_by(navigator.to_goal, on_line)
    return None


# Directions at a new hit point.


def keep_direction(navigator: Navigator) -> str:
    """Take the configured one."""
    return navigator.configured


def alternate_direction(navigator: Navigator) -> str:
    """Take the other one at each new hit point, and at one met again the opposite of then."""
    turned = {"left": "right", "right": "left"}
    for point, way in reversed(list(zip(navigator.hits, navigator.ways, strict=True))):
        if hypot(point[0] - navigator.x, point[1] - navigator.y) <= 0.40:
            return turned[way]
    return turned[navigator.direction] if navigator.hits else navigator.configured


def direction_by_slope(navigator: Navigator) -> str:
    """Turn the way that needs less turning along the wall."""
    bearing = navigator.around.slope(navigator.bearing)
    if bearing is None or abs(bearing) < 0.02:
        return navigator.configured
    return "left" if bearing < 0 else "right"


def direction_of_sliding(navigator: Navigator) -> str:
    """Go on the way it slid along the wall."""
    return navigator.slid


MOTIONS: dict[str, Callable[[Navigator], float | None]] = {
    words.STRAIGHT: go_straight,
    words.LINE: go_along_line,
    words.TANGENT: go_by_tangents,
}
LEAVES: dict[str, Callable[[Navigator], Command | None]] = {
    words.ANYWHERE: leave_anywhere,
    words.LINE: leave_on_line,
    words.NEAREST_POINT: leave_at_nearest,
}
NEARNESS: dict[str, Callable[[Navigator], Command | None]] = {
    words.FREE_WAY: leave_by_free_way,
    words.FREE_RANGE: leave_by_free_range,
    words.VISIBLE_POINTS: leave_by_visible_points,
}
DIRECTIONS: dict[str, Callable[[Navigator], str]] = {
    words.FIXED: keep_direction,
    words.ALTERNATE: alternate_direction,
    words.SLOPE: direction_by_slope,
    words.SLIDING: direction_of_sliding,
}
