"""Component that notes how late each of its cycles begins."""

import time
from array import array

from rtkit.component import Component, Manager, Parameter


class Beat(Component):
    """Note how late each cycle begins, until there are enough; then write it into a file."""

    result = Parameter("")
    count = Parameter(100)

    def on_activated(self, context: str) -> None:
        self._context = self.participation(context)
        self._missed = self._context.missed
        self._turn = array("q", [0])

    def on_execute(self, context: str) -> None:
        self._turn.append(time.monotonic_ns() - self._context.deadline_ns)
        if len(self._turn) == self.count + 1:
            self._turn[0] = self._context.missed - self._missed
            with open(self.result, "wb") as file:
                self._turn.tofile(file)


def BeatInit(manager: Manager) -> None:  # noqa: N802
    manager.register_factory(Beat)
