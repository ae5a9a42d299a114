"""A sink of poses, for watching a robot drive."""

from __future__ import annotations

from rtkit.component import Component, InPort, Manager, TimedPose2D


class PoseLog(Component):
    """Write to the log, four times a second, where the robot is."""

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 4.0

    pose = InPort(TimedPose2D, doc="Where the robot is")

    def on_execute(self, context: str) -> None:
        """Log the newest pose."""
        poses = self.pose.read_all()
        if poses:
            self.logger.info("x = %.2f m", poses[-1].data.position.x)


def PoseLogInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(PoseLog)
