"""Behaviours of mobile robots: what leads them somewhere, how it is started, told and stopped."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

import rtkit
from rtkit.errors import Refused
from rtkit.services.chassis import Chassis
from rtkit.services.frames import Frames
from rtkit.services.running import Behavior, Goal, Running, Twist

NEAR = 0.01
"""How near a target is reached [m, rad]."""
_PASSED = 0.10
"""How near the points of a route are passed [m]."""
_STUCK_S = 1.5


class MoveTo:
    """Leads a robot straight from point to point; what is in its way ends that."""

    def __init__(self, chassis: Chassis, route: Sequence[Goal]) -> None:
        self._chassis = chassis
        self.remaining = list(route)
        self._still_s = 0.0
        self._before = chassis.pose

    def step(self, seconds: float) -> Twist | None:
        """Return how to move next."""
        chassis = self._chassis
        while self.remaining:
            goal, is_last = self.remaining[0], len(self.remaining) == 1
            dx, dy = goal.x - chassis.pose[0], goal.y - chassis.pose[1]
            far = math.hypot(dx, dy)
            bearing = math.remainder(math.atan2(dy, dx) - chassis.pose[2], math.tau)
            if far > (NEAR if is_last else _PASSED):
                twist = chassis.steer(far if is_last else math.inf, bearing, seconds)
                self._watch(twist, seconds)
                return twist
            turn = 0.0 if goal.theta is None else goal.theta - chassis.pose[2]
            turn = math.remainder(turn, math.tau)
            if is_last and abs(turn) > NEAR:
                return 0.0, 0.0, chassis.bounded(turn / max(seconds, 0.2))
            del self.remaining[0]
        return None

    def _watch(self, twist: Twist, seconds: float) -> None:
        """Raise `Refused` where it does not get on."""
        x, y, _ = self._chassis.pose
        wanted = math.hypot(*twist[:2]) * seconds
        went = math.hypot(x - self._before[0], y - self._before[1])
        self._before = self._chassis.pose
        is_still = wanted > 10 * went and not self._chassis.trouble
        self._still_s = self._still_s + seconds if is_still else 0.0
        if self._still_s > _STUCK_S:
            raise Refused(f"something is in the way at ({x:.2f} {y:.2f})")


Target = rtkit.Marker | list[rtkit.Marker] | rtkit.Element
"""Value that starts a behaviour, or tells how it stands."""


def behaviors_of(chassis: Chassis, frames: Frames, kinds: dict[str, Callable[..., Any]]) -> object:
    """Return an object whose properties are behaviours: SET one to start it, GET how it stands."""

    def stop(self: object, now: bool = True) -> None:
        """End the behaviour that runs."""
        if now:
            chassis.halt()

    found: dict[str, Any] = {"__doc__": "Behaviours of a robot.", "stop": stop}
    for name, kind in kinds.items():
        found[f"get_{name}"], found[f"set_{name}"] = _accessors(chassis, frames, name, kind)
    return type("Behaviors", (), found)()


def _accessors(
    chassis: Chassis, frames: Frames, name: str, kind: Callable[..., Behavior]
) -> tuple[Callable[..., Any], Callable[..., Any]]:
    def get(self: object) -> Target:
        running = chassis.running
        if running is None or running.name != name:
            empty = (rtkit.Element("target"), rtkit.Element("remaining", {}, (), ()))
            return rtkit.Element("behavior", {"state": "idle"}, empty)
        return running.describe()

    def set_(self: object, target: Target) -> None:
        given = target if isinstance(target, list) else [target]
        markers = [each for each in given if isinstance(each, rtkit.Marker)]
        if not markers or markers != given:
            raise rtkit.PropertyError("bad-value", "expected a marker or a list of them")
        route = [_goal(each, frames) for each in markers]
        chassis.follow(Running(name, kind(chassis, route), markers))

    get.__doc__ = f"How {name} stands; a marker, or a list of them, starts it."
    return get, set_


def _goal(marker: rtkit.Marker, frames: Frames) -> Goal:
    """Return where a marker is in the world; one without a frame is of the robot's base."""
    if marker.location is None:
        raise rtkit.PropertyError("bad-value", "the marker has no location")
    return Goal(frames.convert(marker.location, marker.frame or "base", "world"))


def loaded(words: str) -> dict[str, Callable[..., Any]]:
    """Return classes by name that are told as ``name=module:Class …``.

    Raises:
        PropertyError: ``bad-value``: it is not of that form, or there is no such class.
    """
    found = {}
    for word in words.split():
        name, _, place = word.partition("=")
        module, _, attribute = place.partition(":")
        if not (name and module and attribute):
            raise rtkit.PropertyError("bad-value", f"no behaviour {word}: it is NAME=MODULE:CLASS")
        try:
            found[name] = getattr(import_module(module), attribute)
        except (ImportError, AttributeError, ValueError) as error:
            raise rtkit.PropertyError("bad-value", f"no behaviour {word}: {error}") from error
    return found
