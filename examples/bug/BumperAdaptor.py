"""Makes hardware abstractions of six contact switches."""

from __future__ import annotations

from rtkit.component import InPort, Manager, TimedBooleanSeq

from .adaptor import NOWHERE, DistanceAdaptor
from .messages import ONE_EACH_TICK
from .senses import BumperSenses


class BumperAdaptor(DistanceAdaptor):
    """Offer what six contact switches of 60 degrees round the body feel."""

    bumper = InPort(TimedBooleanSeq, properties=ONE_EACH_TICK, doc="Ahead first, counter-clockwise")

    def on_execute(self, context: str) -> None:
        """Take the switches of this step."""
        self.seen = BumperSenses(NOWHERE, self.next_of(self.bumper).data)


def BumperAdaptorInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(BumperAdaptor)
