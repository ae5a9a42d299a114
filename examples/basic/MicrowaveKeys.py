"""The keys, the door and the clock of a microwave oven."""

from __future__ import annotations

from rtkit.component import Component, Manager, OutPort, Parameter, Time, TimedLong


class MicrowaveKeys(Component):
    """Press one key after the other, one each period.

    Each out port is an event of the oven; connect it to the port `event`, which knows it by name.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 10.0

    open = OutPort(TimedLong, doc="The door is opened")
    close = OutPort(TimedLong, doc="The door is closed")
    minute = OutPort(TimedLong, doc="A minute more")
    start = OutPort(TimedLong, doc="Begin")
    stop = OutPort(TimedLong, doc="End")
    tick = OutPort(TimedLong, doc="A minute has passed")
    keys = Parameter("minute,minute,start,tick,open,close,start,tick", doc="What is pressed")

    def on_activated(self, context: str) -> None:
        """Begin with the first key."""
        self._keys = [key.strip() for key in self.keys.split(",") if key.strip() in self.ports]

    def on_execute(self, context: str) -> None:
        """Press the next key, as long as there is one."""
        if self._keys:
            port = self.ports[self._keys.pop(0)]
            if isinstance(port, OutPort):
                port.write(TimedLong(Time.now(), 1))


def MicrowaveKeysInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(MicrowaveKeys)
