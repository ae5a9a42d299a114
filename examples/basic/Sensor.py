"""A simulated distance sensor."""

from __future__ import annotations

from rtkit.component import (
    Component,
    InPort,
    Manager,
    OutPort,
    Parameter,
    Time,
    TimedDouble,
    TimedPose2D,
)


class Sensor(Component):
    """Measure the distance to a wall across the x axis.

    Connect `pose` to the robot's pose to close the loop; without, the robot stands at 0.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 100.0

    pose = InPort(TimedPose2D, doc="Where the robot is")
    distance = OutPort(TimedDouble, doc="Distance to the wall [m]")
    wall = Parameter(5.0, unit="m", doc="Where the wall is")

    def on_execute(self, context: str) -> None:
        """Measure once."""
        poses = self.pose.read_all()
        if poses:
            self._x = poses[-1].data.position.x
        self.distance.write(TimedDouble(Time.now(), max(0.0, self.wall - self._x)))

    def on_activated(self, context: str) -> None:
        """Begin where the robot stands."""
        self._x = 0.0


def SensorInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Sensor)
