"""A simulated drive."""

from __future__ import annotations

from math import cos, sin

from rtkit.component import (
    Component,
    InPort,
    Manager,
    OutPort,
    Parameter,
    Point2D,
    Pose2D,
    Time,
    TimedPose2D,
    TimedVelocity2D,
    Velocity2D,
)

_STANDING = Velocity2D()


class Motor(Component):
    """Drive as told and tell where that leads, integrating once each period.

    Velocities are those of the robot's own frame.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 100.0

    velocity = InPort(TimedVelocity2D, doc="How to drive")
    pose = OutPort(TimedPose2D, doc="Where the robot is")
    patience = Parameter(0.5, unit="s", doc="Stop when no velocity arrives for so long")

    def on_activated(self, context: str) -> None:
        """Stand at the origin."""
        self._x = self._y = self._heading = self._waited_s = 0.0
        self._velocity = _STANDING

    def on_execute(self, context: str) -> None:
        """Move for one period."""
        step_s = 1.0 / self.context_rate(context)
        told = self.velocity.read_all()
        self._waited_s = 0.0 if told else self._waited_s + step_s
        if told:
            self._velocity = told[-1].data
        elif self._waited_s > self.patience:
            self._velocity = _STANDING
        self._move(step_s)
        pose = Pose2D(Point2D(self._x, self._y), self._heading)
        self.pose.write(TimedPose2D(Time.now(), pose))

    def _move(self, step_s: float) -> None:
        velocity, heading = self._velocity, self._heading
        self._x += (velocity.vx * cos(heading) - velocity.vy * sin(heading)) * step_s
        self._y += (velocity.vx * sin(heading) + velocity.vy * cos(heading)) * step_s
        self._heading += velocity.va * step_s


def MotorInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Motor)
