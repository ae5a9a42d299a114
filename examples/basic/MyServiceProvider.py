"""Offers a service to other components."""

from __future__ import annotations

from collections import deque
from typing import Protocol

from rtkit.component import Component, Manager, ServicePort

_HISTORY = 100


class MyService(Protocol):
    """Echoes texts and keeps a number; what was given is remembered."""

    def echo(self, text: str) -> str:
        """Return the text."""

    def get_echo_history(self) -> list[str]:
        """Return the texts that were echoed, the oldest first."""

    def set_value(self, value: float) -> None:
        """Keep a number."""

    def get_value(self) -> float:
        """Return the number that is kept."""

    def get_value_history(self) -> list[float]:
        """Return the numbers that were kept, the oldest first."""


class MyServiceProvider(Component):
    """Provide MyService: echo texts, keep a number.

    It has no cycle of its own: callers use it from their threads, several of them at once.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 10.0

    myservice = ServicePort.provided(MyService, "myservice0", doc="Echoes, and a number")

    def on_initialize(self) -> None:
        """Begin with nothing remembered."""
        self._echoes: deque[str] = deque(maxlen=_HISTORY)
        self._values: deque[float] = deque([0.0], maxlen=_HISTORY)

    def echo(self, text: str) -> str:
        """Return the text."""
        self._echoes.append(text)
        return text

    def get_echo_history(self) -> list[str]:
        """Return the texts that were echoed, the oldest first."""
        return list(self._echoes)

    def set_value(self, value: float) -> None:
        """Keep a number."""
        self._values.append(value)

    def get_value(self) -> float:
        """Return the number that is kept."""
        return self._values[-1]

    def get_value_history(self) -> list[float]:
        """Return the numbers that were kept, the oldest first."""
        return list(self._values)


def MyServiceProviderInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(MyServiceProvider)
