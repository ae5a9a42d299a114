"""A source of numbers, for trying connections."""

from __future__ import annotations

from rtkit.component import Component, Manager, OutPort, Parameter, Time, TimedLong


class ConsoleIn(Component):
    """Write the numbers of a parameter, one each period, over and over."""

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 10.0

    out = OutPort(TimedLong, doc="The numbers")
    values = Parameter((0,), doc="What is written, one after another")

    def on_activated(self, context: str) -> None:
        """Begin with the first number."""
        self._count = 0

    def on_execute(self, context: str) -> None:
        """Write the next number."""
        values = self.values
        if values:
            self.out.write(TimedLong(Time.now(), values[self._count % len(values)]))
            self._count += 1


def ConsoleInInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(ConsoleIn)
