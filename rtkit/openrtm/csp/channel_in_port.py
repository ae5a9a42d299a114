"""An in port whose connectors may be channels: it asks for values while it has room for them."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rtkit.component.ports.buffer import GuardedRing, Sink, Source
from rtkit.component.ports.connector_events import ConnectorEvent
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.options import BufferOptions, EmptyPolicy, PortStatus, is_channel
from rtkit.errors import Malformed
from rtkit.link.threads import start_thread
from rtkit.logs.late import late
from rtkit.openrtm.csp.meeting import CHANNELS, Meeting, number_in
from rtkit.rtc.profiles import ConnectorProfile

_LENGTHS = ("dataport.inport.buffer.length", "dataport.buffer.length", "buffer.length")
_USUAL_LENGTH = 8
_AGAIN_S = 0.05
"""Pause of a channel whose writer does not answer, or is gone [s]."""
_log = late(__name__)


class ChannelInPort(InPort[Any]):
    """An in port that asks for values over its channels.

    Attributes:
        meeting: What its reader and its channels wait at.
        readers: Number of those who wait for a value.
    """

    def _begin(self) -> None:
        super()._begin()
        self.properties.update(CHANNELS)
        self.meeting = Meeting()
        self.readers = 0
        self.listen(None)

    def listen(self, listener: Callable[[], None] | None) -> None:
        """See `InPort.listen`; those at the meeting are told anyway."""

        def ring_and_call() -> None:
            self.meeting.ring()
            if listener is not None:
                listener()

        super().listen(ring_and_call)

    def open_pull(self, connector: ConnectorProfile, source: Source[Any]) -> None:
        """Open a connector that is pulled.

        Raises:
            Refused: It is open already, or the port takes no more.
            Malformed: A property cannot be read.
        """
        if not is_channel(connector.properties):
            super().open_pull(connector, source)
            return
        length = self._length(connector)
        ring = ChannelRing(self, source, length, lambda: self._keep(connector, ring))
        self._wire(connector, ring)
        start_thread(ring.fill, f"channel {connector.connector_id}")

    def _wire(self, connector: ConnectorProfile, ring: ChannelRing) -> None:
        """Have the values of a channel read, and its listeners told."""
        id = connector.connector_id
        self._add(connector, ring, EmptyPolicy.DO_NOTHING)
        self._renewals[id] = (ring, ring.use)
        self.renew(id)
        self._notify(ConnectorEvent.CONNECTED, connector)

    def _keep(self, connector: ConnectorProfile, ring: ChannelRing) -> None:
        """Have what came while a channel was closed read, too: its writer was told so."""
        with self._lock:
            if all(each is not ring for _, each in self._left):
                self._left = (*self._left, (connector, ring))
            self._refresh()

    def _length(self, connector: ConnectorProfile) -> int:
        """Return how many values are asked for before they are read."""
        stated = {**self.properties, **connector.properties}
        key = next((each for each in _LENGTHS if stated.get(each, "").strip()), _LENGTHS[0])
        return int(number_in(stated, key, _USUAL_LENGTH))


@contextmanager
def reading(*ports: ChannelInPort) -> Iterator[None]:
    """Have the channels of ports without buffer ask while this is entered."""
    for each in ports:
        with each.meeting.changed:
            each.readers += 1
            each.meeting.changed.notify_all()
    try:
        yield
    finally:
        for each in ports:
            with each.meeting.changed:
                each.readers -= 1


class ChannelRing(GuardedRing[Any]):
    """The values of one channel that were not read yet, and the thread that asks for more.

    One of length 0 asks while somebody waits for a value, and the port has none.
    """

    def __init__(
        self, port: ChannelInPort, source: Source[Any], length: int, keep: Callable[[], None]
    ) -> None:
        super().__init__(BufferOptions(length=max(length, 1)))
        self._changed = port.meeting.changed
        self._port = port
        self._source = source
        self._sink: Sink[Any] = self.write
        self._keep = keep
        self._is_unbuffered = length == 0

    def write(self, value: Any) -> PortStatus | None:
        """Take a value: it was asked for, so there is room, also when this was just closed."""
        with self._changed:
            self._items.append(value)
            self._changed.notify_all()
        return None

    def use(self, sink: Sink[Any]) -> None:
        """Give values that come to another sink from now on."""
        self._sink = sink

    def share(self, items: deque[Any]) -> None:
        """Have the room depend on what is in a queue that the sink fills."""
        self._items = items

    def fill(self) -> None:
        """Ask, whenever there is room, until this is closed."""
        while self._await_room():
            began = time.monotonic()
            try:
                value = self._source()
            except Malformed as error:
                _log().warning("port %s: value dropped: %s", self._port.name, error)
                continue
            if value is not None:
                self._sink(value)
                if self._is_closed:
                    self._keep()
                    self._port.meeting.ring()
            elif time.monotonic() - began < _AGAIN_S:  # nobody answered
                with self._changed:
                    self._changed.wait_for(lambda: self._is_closed, _AGAIN_S)

    def _await_room(self) -> bool:
        with self._changed:
            self._changed.wait_for(lambda: self._is_closed or self._has_room())
            return not self._is_closed

    def _has_room(self) -> bool:
        if self._is_unbuffered:
            return self._port.readers > 0 and not self._port.is_new()
        return len(self) < self.length
