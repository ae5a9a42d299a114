"""Following by touch: what the navigator does where no sensor measures a range."""

from __future__ import annotations

from math import atan2, dist, hypot, pi, remainder, tau
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .algorithm import Command, Navigator, Point

_SIDE, _BEHIND = pi / 3, 2 * pi / 3
"""The bearings of the switches beside the robot: further ahead, further behind."""
_FELT = 0.105
"""How far from the centre a place is that is felt [m]."""
_TRIAL = 0.1
"""How far a way is tried [m]."""


def follow_by_touch(navigator: Navigator, side: float) -> Command:
    """Return the command along a wall: turn from what is felt ahead, go on, bend to what is lost.

    Args:
        navigator: Which follows it.
        side: 1 with the wall on the right, -1 with it on the left.
    """
    senses, around = navigator.senses, navigator.around
    on_side = senses.obstacle_on_the_right() if side > 0 else senses.obstacle_on_the_left()
    before = on_side and senses.free_distance(-side * _SIDE) == 0
    behind = on_side and senses.free_distance(-side * _BEHIND) == 0
    if senses.obstacle_in_front_of_the_robot() and not before:
        ahead = senses.free_distance(0.0) == 0
        beside = pi / 2 if senses.free_distance(side * _BEHIND) == 0 else _SIDE
        around.touch(0.0 if ahead else side * beside, _FELT)
        navigator.seeks = None
        return 0.0, side * 0.9
    if on_side:
        navigator.seeks = None
    elif navigator.seeks is not None:
        return _seek(navigator, navigator.seeks)
    went_from, navigator.went_from = navigator.went_from, None
    is_blocked = went_from is not None and dist(went_from, navigator.here) < 0.01
    if before and not behind:
        around.touch(-side * _SIDE, _FELT)
        return 0.0, side * 0.5
    if on_side:
        around.touch(-side * pi / 2, _FELT)
        if is_blocked:
            return 0.0, side * 0.35
        navigator.went_from = navigator.here
        return 0.2, (0.0 if before else -side * 0.4)
    return 0.14, -side * 1.1


def _seek(navigator: Navigator, place: Point) -> Command:
    """Return the command to where the wall was felt, which a turn-round left on the other side."""
    x, y = navigator.here
    if dist(place, navigator.here) < _FELT:  # the wall is not there: it bends to it again
        navigator.seeks = None
    bearing = remainder(atan2(place[1] - y, place[0] - x) - navigator.theta, tau)
    return (0.2, 0.0) if navigator.is_facing(bearing) else navigator.face(bearing)


def way_free_by_trial(navigator: Navigator) -> bool | Command | None:
    """Return whether the way to the goal is free, or the command that tries it."""
    if navigator.trial is not None:
        far = hypot(navigator.x - navigator.trial[0], navigator.y - navigator.trial[1])
        navigator.trial, navigator.decided_at = None, navigator.here
        return far > 0.9 * _TRIAL and not navigator.obstacle_in_front_of_the_robot()
    if navigator.was_decided():
        return None
    if not navigator.is_facing(navigator.bearing):
        navigator.looks_from = navigator.here
        return navigator.face_goal()
    navigator.trial = navigator.here
    return _TRIAL / 0.5, 0.0
