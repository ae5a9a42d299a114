"""In ports that keep values as they were sent, with the time of arrival."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import NamedTuple, cast

from rtkit.component.ports.buffer import Sink
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.options import PortStatus
from rtkit.probe.backlog import Backlog


class Arrival(NamedTuple):
    """One value.

    Attributes:
        stream: Name of the stream that brought it.
        time_ns: When it arrived, Unix time [ns].
        payload: The value in CDR; a view, where it is large.
    """

    stream: str
    time_ns: int
    payload: bytes


class Tap(InPort[bytes]):
    """An in port of any data type; reading returns arrivals.

    Attributes:
        backlog: Bounds the values that wait for the tool; None where nothing does.
    """

    is_undecoded = True

    def __init__(self, name: str, properties: Mapping[str, str] | None = None) -> None:
        super().__init__(bytes, name, properties)
        self.backlog: Backlog | None = None
        self._refused = 0

    def copy(self) -> Tap:
        """Return a port of the same kind without connectors."""
        return Tap(self.name, self.properties)

    @property
    def lost(self) -> int:
        """Number of values that had no place here."""
        return super().lost + self._refused

    def take(self) -> list[Arrival]:
        """Return the arrivals since the last call."""
        return cast("list[Arrival]", self.read_all())

    def _with_listener(self, write: Sink[bytes]) -> Sink[bytes]:
        keep = super()._with_listener(write)
        name = self.name

        def stamp(payload: bytes) -> PortStatus | None:
            arrival = Arrival(name, time.time_ns(), payload)
            if self.backlog is None:
                return keep(cast(bytes, arrival))
            if not self.backlog.enter(payload):
                self._refused += 1
                return PortStatus.FULL
            refused = keep(cast(bytes, arrival))
            if refused is not None:
                self.backlog.leave([payload])
            return refused

        return stamp
