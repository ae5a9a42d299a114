"""Makes hardware abstractions of a laser scan and three infra-red ranges."""

from __future__ import annotations

from rtkit.component import InPort, Manager, RangeData, TimedDoubleSeq

from .adaptor import NOWHERE, DistanceAdaptor
from .messages import ONE_EACH_TICK
from .senses import CombinedSenses


class CombinedAdaptor(DistanceAdaptor):
    """Offer what a laser and three infra-red cones see together."""

    scan = InPort(RangeData, properties=ONE_EACH_TICK, doc="Beams from right to left [m]")
    ir = InPort(TimedDoubleSeq, properties=ONE_EACH_TICK, doc="Ranges: ahead, left, right [m]")

    def on_execute(self, context: str) -> None:
        """Take both of this step."""
        self.seen = CombinedSenses(
            NOWHERE, self.next_of(self.scan).ranges, self.next_of(self.ir).data
        )


def CombinedAdaptorInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(CombinedAdaptor)
