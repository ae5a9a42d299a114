"""Makes hardware abstractions of three infra-red ranges."""

from __future__ import annotations

from rtkit.component import InPort, Manager, TimedDoubleSeq

from .adaptor import NOWHERE, DistanceAdaptor
from .messages import ONE_EACH_TICK
from .senses import InfraRedSenses


class IrAdaptor(DistanceAdaptor):
    """Offer what three infra-red cones of 26 degrees see, up to 2 m: ahead, left, right."""

    ir = InPort(TimedDoubleSeq, properties=ONE_EACH_TICK, doc="Ranges: ahead, left, right [m]")

    def on_execute(self, context: str) -> None:
        """Take the ranges of this step."""
        self.seen = InfraRedSenses(NOWHERE, self.next_of(self.ir).data)


def IrAdaptorInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(IrAdaptor)
