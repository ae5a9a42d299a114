"""Source of many values, as fast as they are taken."""

from __future__ import annotations

import os

from rtkit.component import Component, Manager, OutPort, Parameter, Time, TimedOctetSeq


class Flood(Component):
    """Write so many values of so many bytes within one period, then nothing."""

    rate = 100.0

    out = OutPort(TimedOctetSeq)
    count = Parameter(1000, doc="Values")
    size = Parameter(64, doc="Bytes of each, but for what the form of data adds")

    def on_activated(self, context: str) -> None:
        """Begin anew."""
        self._left = self.count

    def on_execute(self, context: str) -> None:
        """Write all that is left."""
        payload = os.urandom(self.size)
        while self._left:
            self._left -= 1
            self.out.write(TimedOctetSeq(Time.now(), payload))


def FloodInit(manager: Manager) -> None:  # noqa: N802
    """Register the component type of this module."""
    manager.register_factory(Flood)
