"""Component of the warm-up: it has one of everything that is common."""

from rtkit.component import Component, InPort, Manager, OutPort, Parameter, TimedLong


class Extra(Component):
    """Does nothing."""

    type_name = "warm_up_component"
    vendor = "rtkit"
    category = "example"
    version = "1.0"

    into = InPort(TimedLong, doc="Values")
    out = OutPort(TimedLong, doc="Values")
    factor = Parameter(1.0, doc="A number")
    offsets = Parameter((0, 0), doc="Numbers")

    def on_activated(self, context: str) -> None:
        """Never called."""

    def on_execute(self, context: str) -> None:
        """Never called."""


def warm_up_componentInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Extra)
