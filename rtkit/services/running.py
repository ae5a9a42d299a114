"""Behaviours as they run: led by whatever was plugged in, stopped, told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import rtkit
from rtkit.errors import RtkitError
from rtkit.services.frames import pose_of

Twist = tuple[float, float, float]
"""Speed ahead, speed to the left, turning, of the base [m/s, m/s, rad/s]."""


class Goal:
    """Point to reach, in the frame of the world.

    Attributes:
        x: Place [m].
        y: The same.
        theta: Heading to end with [rad], None where the marker tells none.
    """

    def __init__(self, location: Sequence[float]) -> None:
        self.x, self.y = location[:2]
        self.theta = pose_of(location)[5] if len(location) == 6 else None


class Behavior(Protocol):
    """Interface of what leads a robot; its class is called with chassis and route for a target."""

    @property
    def remaining(self) -> Sequence[Goal]:
        """Rest of the route."""

    def step(self, seconds: float) -> Twist | None:
        """Return how to move next, for so long; None at the end.

        Raises:
            Exception: It cannot be done: the text tells why.
        """


class Running:
    """One start of a behaviour, and how it stands.

    Attributes:
        state: ``running``, ``done``, ``failed`` or ``stopped``.
    """

    def __init__(self, name: str, leader: Behavior, markers: Sequence[rtkit.Marker]) -> None:
        self.name = name
        self.state = "running"
        self._leader = leader
        self._markers = markers
        self._error, self._code = "", ""

    def step(self, seconds: float) -> Twist | None:
        """Return how to move next; None when it has ended."""
        twist, state = None, "done"
        try:
            twist = self._leader.step(seconds)
        except Exception as error:  # of a user: the robot stands, and others go on
            is_ours = isinstance(error, RtkitError)
            self._code = getattr(error, "code", "conflict") if is_ours else "internal"
            kind = "" if is_ours else f"{type(error).__name__}: "
            state, self._error = "failed", f"{kind}{error}"
        if twist is None and self.state == "running":
            self.state = state
        return twist

    def stop(self) -> None:
        """End it."""
        if self.state == "running":
            self.state = "stopped"

    def describe(self) -> rtkit.Element:
        """Return state, target and what remains, as far as it is known."""
        goals = [] if self.state == "done" else self._leader.remaining
        now = self._markers[max(0, len(self._markers) - max(len(goals), 1))]
        children = [
            rtkit.Element("target", {}, now.element.children),
            rtkit.Element("remaining", {}, (), tuple((each.x, each.y) for each in goals)),
        ]
        if self._error:
            children.append(rtkit.Element("error", {"code": self._code}, (), self._error))
        return rtkit.Element("behavior", {"state": self.state}, tuple(children))
