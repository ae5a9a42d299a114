"""Measuring end of the round trip."""

from __future__ import annotations

import statistics
import time

from rtkit.component import (
    Component,
    InPort,
    Manager,
    OutPort,
    Parameter,
    Pose2D,
    Time,
    TimedPose2D,
)


class Ping(Component):
    """Send a pose, wait until it is back, and again; write how long that takes to a file."""

    rate = 1.0

    out = OutPort(TimedPose2D)
    back = InPort(TimedPose2D)
    count = Parameter(500, doc="Round trips")
    result = Parameter("", doc="File for the median of one round trip [us]")

    def on_activated(self, context: str) -> None:
        """Warm up and measure."""
        self._trips(50)
        median_s = statistics.median(self._trips(self.count))
        with open(self.result, "w", encoding="utf-8") as file:
            file.write(f"{median_s * 1e6}")

    def _trips(self, count: int) -> list[float]:
        taken = []
        for _ in range(count):
            begin = time.perf_counter()
            self.out.write(TimedPose2D(Time(), Pose2D()))
            if self.back.read() is None:
                raise TimeoutError("nothing came back")
            taken.append(time.perf_counter() - begin)
        return taken


def PingInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(Ping)
