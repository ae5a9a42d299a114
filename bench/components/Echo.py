"""Answering end of the round trip."""

from __future__ import annotations

from rtkit.component import Component, InPort, Manager, OutPort, TimedPose2D


class Echo(Component):
    """Send back what arrives, at once."""

    rate = 1000.0

    into = InPort(TimedPose2D)
    out = OutPort(TimedPose2D)

    def on_execute(self, context: str) -> None:
        """Wait for values and send each back, until none comes for a while."""
        while (value := self.into.read()) is not None:
            self.out.write(value)


def EchoInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Echo)
