"""Component that writes a number ten times a second, and takes what comes."""

from __future__ import annotations

from rtkit.component import Component, InPort, Manager, OutPort, Time, TimedLong


class Tick(Component):
    """Write how many periods there have been."""

    rate = 10.0

    into = InPort(TimedLong)
    out = OutPort(TimedLong)

    def on_initialize(self) -> None:
        """Begin at zero."""
        self._count = 0

    def on_execute(self, context: str) -> None:
        """Take what has come and write the next number."""
        self.into.read_all()
        self._count += 1
        self.out.write(TimedLong(Time.now(), self._count))


def TickInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Tick)
