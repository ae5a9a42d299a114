"""A controller that stops a robot in front of an obstacle."""

from __future__ import annotations

from rtkit.component import (
    Component,
    InPort,
    Manager,
    OutPort,
    Parameter,
    Time,
    TimedDouble,
    TimedVelocity2D,
    Velocity2D,
)


class Controller(Component):
    """Drive towards an obstacle and stop in front of it."""

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 100.0

    distance = InPort(TimedDouble, doc="Distance to the obstacle [m]")
    velocity = OutPort(TimedVelocity2D, doc="Where to drive")
    gain = Parameter(1.0, unit="1/s", doc="Speed per distance that is left")
    stop_distance = Parameter(1.0, unit="m", doc="Where to stop")
    max_speed = Parameter(0.5, unit="m/s", doc="Upper limit of the speed")

    def on_execute(self, context: str) -> None:
        """Choose a speed for the newest distance."""
        distances = self.distance.read_all()
        if distances:
            left = distances[-1].data - self.stop_distance
            self._drive(min(self.max_speed, max(0.0, self.gain * left)))

    def on_deactivated(self, context: str) -> None:
        """Stop the robot."""
        self._drive(0.0)

    def on_aborting(self, context: str) -> None:
        """Stop the robot."""
        self._drive(0.0)

    def _drive(self, speed: float) -> None:
        self.velocity.write(TimedVelocity2D(Time.now(), Velocity2D(vx=speed)))


def ControllerInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Controller)
