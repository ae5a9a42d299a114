"""Configuration parameters of every kind."""

from __future__ import annotations

from typing import Any

from rtkit.component import Component, Manager, Parameter

_NAMES = (
    "int_param0",
    "int_param1",
    "double_param0",
    "double_param1",
    "bool_param0",
    "str_param0",
    "str_param1",
    "vector_param0",
)


class ConfigSample(Component):
    """Log each parameter whose value changes."""

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 10.0

    int_param0 = Parameter(0, doc="An integer", constraint="0<=x<=100", widget="slider.1")
    int_param1 = Parameter(1, doc="An integer", constraint="0<=x<=100", widget="spin")
    double_param0 = Parameter(0.11, doc="A number", constraint="-10<=x<=10", widget="slider.0.1")
    double_param1 = Parameter(9.9, doc="A number", unit="m", widget="text")
    bool_param0 = Parameter(False, doc="A truth value", constraint="(true,false)", widget="radio")
    str_param0 = Parameter("one", doc="A word", constraint="(one,two,three)", widget="radio")
    str_param1 = Parameter("dara", doc="Some text", widget="text")
    vector_param0 = Parameter((0.0, 1.0, 2.0, 3.0, 4.0), doc="A vector", widget="text")

    def on_activated(self, context: str) -> None:
        """Take all values for new."""
        self._seen: dict[str, Any] = {}

    def on_execute(self, context: str) -> None:
        """Log what changed since the last period."""
        for name in _NAMES:
            value = getattr(self, name)
            if self._seen.get(name) != value:
                self._seen[name] = value
                self.logger.info("%s is %r", name, value)


def ConfigSampleInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(ConfigSample)
