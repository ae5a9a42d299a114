"""Makes the hardware abstractions of place and heading of what odometry says."""

from __future__ import annotations

from rtkit.component import Component, InPort, Manager, Point2D, Pose2D, ServicePort, TimedPose2D
from rtkit.errors import Refused

from .messages import ONE_EACH_TICK, Localisation


class _Service:
    """Answers for where odometry takes the robot to be now."""

    def __init__(self, adaptor: OdometryAdaptor) -> None:
        self._adaptor = adaptor

    @property
    def _seen(self) -> Pose2D:
        if self._adaptor.seen is None:
            raise Refused(f"{self._adaptor.instance} knows no place yet")
        return self._adaptor.seen

    def position(self) -> Point2D:
        """Return the place [m]."""
        return self._seen.position

    def heading(self) -> float:
        """Return the heading [rad]."""
        return self._seen.heading


class OdometryAdaptor(Component):
    """Offer where the robot is.

    Attributes:
        seen: Where it is in this step; None before the first one.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    execution_type = "ExtTrigExecutionContext"

    pose = InPort(TimedPose2D, properties=ONE_EACH_TICK, doc="What odometry says [m, rad]")
    localisation = ServicePort.provided(
        Localisation, "localisation0", implementation=_Service, doc="Place and heading"
    )
    seen: Pose2D | None = None

    def on_activated(self, context: str) -> None:
        """Forget what an earlier run has left."""
        self.seen = None
        self.pose.read_all()

    def on_execute(self, context: str) -> None:
        """Take the place of this step."""
        pose = self.pose.read()
        if pose is None:
            raise Refused(f"no place came at {self.instance} in this step")
        self.seen = pose.data


def OdometryAdaptorInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(OdometryAdaptor)
