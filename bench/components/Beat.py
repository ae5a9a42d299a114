"""Component that notes the begin of each of its periods."""

import time
from array import array

from rtkit.component import Component, Manager, Parameter


class Beat(Component):
    """Take the time once each period, until there are enough; then write it into a file."""

    result = Parameter("")
    count = Parameter(100)

    def on_activated(self, context: str) -> None:
        self._stamps = array("q")

    def on_execute(self, context: str) -> None:
        self._stamps.append(time.monotonic_ns())
        if len(self._stamps) == self.count:
            with open(self.result, "wb") as file:
                self._stamps.tofile(file)


def BeatInit(manager: Manager) -> None:  # noqa: N802
    manager.register_factory(Beat)
