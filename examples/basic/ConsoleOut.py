"""A sink of numbers, for trying connections."""

from __future__ import annotations

from rtkit.component import Component, InPort, Manager, TimedLong


class ConsoleOut(Component):
    """Write each number that arrives to the log, and keep the last one."""

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 10.0

    in_ = InPort(TimedLong, doc="The numbers")
    last: TimedLong | None = None

    def on_execute(self, context: str) -> None:
        """Log what arrived since the last period."""
        for value in self.in_.read_all():
            self.logger.info("received %d (stamped %d s)", value.data, value.tm.sec)
            self.last = value


def ConsoleOutInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(ConsoleOut)
