"""Both ends of the round trip of an image, and of a stream of them."""

from __future__ import annotations

import os
import statistics
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rtkit.component import Component, InPort, Manager, OutPort, Parameter


@dataclass(frozen=True, slots=True)
class Picture:
    """Pixels, as an array."""

    pixels: NDArray[np.uint8]


class ImagePing(Component):
    """Send an image, wait until it is back, and again; write how long that takes to a file."""

    rate = 1.0

    out = OutPort(Picture)
    back = InPort(Picture)
    count = Parameter(500, doc="Round trips")
    size = Parameter(1_000_000, doc="Of the image [bytes]")
    result = Parameter("", doc="File for the median of one round trip [us]")

    def on_activated(self, context: str) -> None:
        """Warm up and measure."""
        self._sent = np.frombuffer(os.urandom(self.size), np.uint8)
        self._trips(20)
        median_s = statistics.median(self._trips(self.count))
        with open(self.result, "w", encoding="utf-8") as file:
            file.write(f"{median_s * 1e6}")

    def _trips(self, count: int) -> list[float]:
        taken = []
        for _ in range(count):
            begin = time.perf_counter()
            self.out.write(Picture(self._sent))
            came = self.back.read()
            taken.append(time.perf_counter() - begin)
            if came is None or came.pixels[-1] != self._sent[-1]:
                raise TimeoutError("it did not come back")
        return taken


class ImageEcho(Component):
    """Send back what arrives, at once."""

    rate = 1000.0

    into = InPort(Picture)
    out = OutPort(Picture)

    def on_execute(self, context: str) -> None:
        """Wait for values and send each back, until none comes for a while."""
        while (value := self.into.read()) is not None:
            self.out.write(value)


class ImageFlood(Component):
    """Write so many images, as fast as they are taken, then nothing."""

    rate = 100.0

    out = OutPort(Picture)
    count = Parameter(100, doc="Images")
    size = Parameter(1_000_000, doc="Of each [bytes]")
    _sent = np.zeros(0, np.uint8)

    def on_activated(self, context: str) -> None:
        """Begin anew, with the same image: to make one takes as long as to send some."""
        self._left = self.count
        if self._sent.size != self.size:
            self._sent = np.frombuffer(os.urandom(self.size), np.uint8)

    def on_execute(self, context: str) -> None:
        """Write all that is left."""
        while self._left:
            self._left -= 1
            self.out.write(Picture(self._sent))


class ImageSink(Component):
    """Read so many images; write to a file when the last one came."""

    rate = 1000.0

    into = InPort(Picture)
    count = Parameter(100, doc="Images")
    result = Parameter("", doc="File for the time at which the last one came, monotonic [ns]")

    def on_activated(self, context: str) -> None:
        """Begin anew."""
        self._left = self.count

    def on_execute(self, context: str) -> None:
        """Wait for images, until none comes for a while."""
        while self._left and self.into.read() is not None:
            self._left -= 1
            if not self._left:
                with open(f"{self.result}.new", "w", encoding="utf-8") as file:
                    file.write(str(time.monotonic_ns()))
                os.rename(f"{self.result}.new", self.result)


def ImagesInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component types of this module."""
    manager.register_factory(ImagePing)
    manager.register_factory(ImageEcho)
    manager.register_factory(ImageFlood)
    manager.register_factory(ImageSink)
