"""Uses a service of another component."""

from __future__ import annotations

from typing import Protocol

from rtkit.component import (
    Component,
    Manager,
    OutPort,
    Parameter,
    ServicePort,
    Time,
    TimedDouble,
    TimedString,
)


class MyService(Protocol):
    """What is used of the service; the provider may offer more."""

    def echo(self, text: str) -> str:
        """Return the text."""

    def set_value(self, value: float) -> None:
        """Keep a number."""

    def get_value(self) -> float:
        """Return the number that is kept."""


class MyServiceConsumer(Component):
    """Have a text echoed and a number kept once each period, and write what comes back.

    A call that fails, or has no answer in time, puts the component into Error; rtcat shows why.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 1.0

    myservice = ServicePort.required(MyService, timeout_s=0.5, doc="Who echoes")
    echoed = OutPort(TimedString, doc="What was echoed")
    value = OutPort(TimedDouble, doc="The number that is kept")
    text = Parameter("hello", doc="What to have echoed")

    def on_activated(self, context: str) -> None:
        """Count from 0."""
        self._count = 0

    def on_execute(self, context: str) -> None:
        """Call the service, if one is connected."""
        if not self.myservice.is_connected:
            return
        service = self.myservice.client
        self._count += 1
        service.set_value(self._count)
        answer = service.echo(f"{self.text} {self._count}")
        self.echoed.write(TimedString(Time.now(), answer))
        self.value.write(TimedDouble(Time.now(), service.get_value()))


def MyServiceConsumerInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(MyServiceConsumer)
