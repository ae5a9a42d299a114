"""Makes hardware abstractions of a laser scan."""

from __future__ import annotations

from rtkit.component import InPort, Manager, RangeData

from .adaptor import NOWHERE, DistanceAdaptor
from .messages import ONE_EACH_TICK
from .senses import LaserSenses


class LaserAdaptor(DistanceAdaptor):
    """Offer what a laser sees: 180 degrees ahead, 0.02 m to 4 m."""

    scan = InPort(RangeData, properties=ONE_EACH_TICK, doc="Beams from right to left [m]")

    def on_execute(self, context: str) -> None:
        """Take the scan of this step."""
        self.seen = LaserSenses(NOWHERE, self.next_of(self.scan).ranges)


def LaserAdaptorInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(LaserAdaptor)
