"""Carries port data to and from programs that speak a wire of live properties, in any language."""

from __future__ import annotations

import rtkit
from rtkit.component import Component, InPort, Manager, OutPort, Time, TimedLong


class Values:
    """Shown as live properties: `received` is the latest value that came, `send` writes one."""

    def __init__(self, out: OutPort[TimedLong]) -> None:
        self.received = 0
        self._out = out

    def send(self, value: int) -> None:
        """Write a value into the out port of the gateway."""
        self._out.write(TimedLong(Time.now(), value))


class Gateway(Component):
    """Serve what comes in as a live property, and write what clients send.

    The service has the name of the instance.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 100.0

    into = InPort(TimedLong, doc="Values for clients")
    out = OutPort(TimedLong, doc="Values of clients")

    def on_initialize(self) -> None:
        """Open the service."""
        self._values = Values(self.out)
        self._served = rtkit.serve(self._values, self.instance)

    def on_execute(self, context: str) -> None:
        """Publish what came."""
        for value in self.into.read_all():
            self._values.received = value.data

    def on_finalize(self) -> None:
        """Close the service."""
        self._served.close()


def GatewayInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Gateway)
