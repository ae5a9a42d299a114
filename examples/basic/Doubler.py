"""Works when a value comes, and only then."""

from __future__ import annotations

from rtkit.component import Component, InPort, Manager, OutPort, TimedLong


class Doubler(Component):
    """Write twice each number that arrives.

    Its execution context is event-driven: it has a cycle when a value arrives, without waiting
    for the end of a period and without any work in between.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    execution_type = "EventDrivenExecutionContext"

    in_ = InPort(TimedLong, doc="A number")
    out = OutPort(TimedLong, doc="Twice that number, with its time stamp")

    def on_execute(self, context: str) -> None:
        """Work on what has come."""
        for value in self.in_.read_all():
            self.out.write(TimedLong(value.tm, 2 * value.data))


def DoublerInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Doubler)
