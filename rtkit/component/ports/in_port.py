"""In port: values arrive at it; part of the data path, used by several threads at once.

Reading is done by the thread that drives the component. Connectors are opened and closed by another
thread, which replaces tuples and never changes one in place.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rtkit.component.ports.buffer import (
    AnyRing,
    AwaitedRing,
    Buffer,
    BufferFeed,
    Pulled,
    Sink,
    Source,
    make_ring,
)
from rtkit.component.ports.connector_events import ConnectorEvent, NotifyingBuffer, receiving
from rtkit.component.ports.data_port import DataPort
from rtkit.component.ports.options import EmptyPolicy, PortStatus
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import ConnectorProfile

T = TypeVar("T")
_MOST_LEFT = 64
"""How many closed connectors an in port keeps the unread values of."""
Renew = Callable[[Sink[T]], object]
"""Receives the sink to use from now on."""
Listener = Callable[[], None]


class InPort(DataPort[T]):
    """A port that values arrive at.

    Attributes:
        read_count: Values that were read.
    """

    port_type = PortType.IN
    limit_key = "dataport.fan_in"

    def _begin(self) -> None:
        self._buffers: tuple[Buffer[T], ...] = ()
        self._read_from: tuple[Buffer[T], ...] = ()  # the same, with those who listen to reads
        self._left: tuple[tuple[ConnectorProfile, Buffer[T]], ...] = ()
        self._policies: dict[str, tuple[AnyRing[T] | Pulled[T], EmptyPolicy]] = {}
        self._waits = False
        self._reads_back = True
        self._renewals: dict[str, tuple[AnyRing[T], Renew[T]]] = {}
        self._feeds: dict[str, BufferFeed] = {}
        self._listener: Listener | None = None
        self._turn = 0
        self._last: T | None = None
        self.read_count = 0

    def is_new(self) -> bool:
        """Return whether a value is there that was not read yet."""
        return any(len(buffer) for buffer in self._buffers)

    @property
    def unread(self) -> int:
        """Number of values that have arrived and were not read yet."""
        return sum(len(each) for each in self._buffers if not isinstance(each, Pulled))

    @property
    def lost(self) -> int:
        """Number of values that its buffers dropped or refused, where their kinds count that."""
        return sum(getattr(buffer, "lost", 0) for buffer in self._buffers)

    def read(self) -> T | None:
        """Return the oldest value not read yet.

        When there is none: the last value again (policy ``readback``, the default), or None; or
        the next one, after waiting (``block``). None while nothing has ever arrived.
        """
        buffers = self._read_from
        if len(buffers) == 1:  # nearly always; one call is enough then
            value = buffers[0].wait() if self._waits else buffers[0].take()
        else:
            value = self._take_in_turn(buffers)
            if value is None and self._waits:
                value = self._wait(buffers)
        if value is None:
            return self._last if self._reads_back else None
        self.read_count += 1
        self._last = value
        return value

    def read_all(self) -> list[T]:
        """Return every value not read yet, those of one connector in order."""
        values = []
        for buffer in self._read_from:
            for _ in range(len(buffer)):
                value = buffer.take()
                if value is not None:
                    values.append(value)
        if values:
            self.read_count += len(values)
            self._last = values[-1]
        return values

    def data_type_for(self, connector: ConnectorProfile) -> type:
        """Return the data type of the values that a connector brings."""
        return self.data_type

    def open(self, connector: ConnectorProfile, renew: Renew[T] | None = None) -> Sink[T]:
        """Open a push connector; return the sink of its values.

        `renew` is called with each new sink that replaces the returned one.

        Raises:
            Refused: It is open already, or the port takes no more.
            Malformed: A property of the connector cannot be read.
        """
        options = self._options(connector).inport
        ring: AnyRing[T] = make_ring(options)
        self._add(connector, ring, options.empty_policy)
        with self._lock:
            if renew is not None:
                self._renewals[connector.connector_id] = (ring, renew)
            sink = self._sink_of(connector.connector_id, ring)
        self._notify(ConnectorEvent.CONNECTED, connector)
        return sink

    def renew(self, connector_id: str) -> None:
        """Pass the sink to use from now on to the opener of the connector."""
        with self._lock:
            if connector_id in self._renewals:
                ring, renew = self._renewals[connector_id]
                renew(self._sink_of(connector_id, ring))

    def listen(self, listener: Listener | None) -> None:
        """Have `listener` called after each value that is pushed in, by the thread that brings it.

        Without listener a value costs nothing but its place in the buffer.
        """
        with self._lock:
            if listener == self._listener:
                return
            self._listener = listener
            self._rewire()

    def feed(self, connector_id: str, feed: BufferFeed) -> None:
        """Let the reader receive by itself what fills the buffer of a connector."""
        with self._lock:
            self._feeds[connector_id] = feed
            self._rewire()

    def fills(self) -> dict[str, tuple[int, int, int]]:
        """Return by connector how many values wait, how many fit, how many were dropped.

        A buffer that overwrites its oldest value counts these only while the port is watched.
        """
        dropped = self._watch.dropped if self._watch is not None else {}
        rings = ((id, ring) for id, (ring, _) in list(self._policies.items()))
        return {
            id: (len(ring), ring.length, getattr(ring, "lost", dropped.get(id, 0)))
            for id, ring in rings
            if not isinstance(ring, Pulled)
        }

    def open_pull(self, connector: ConnectorProfile, source: Source[T]) -> None:
        """Open a pull connector: reading asks `source`.

        Raises:
            Refused: It is open already, or the port takes no more.
            Malformed: A property of the connector cannot be read.
        """
        options = self._options(connector).inport
        # An in port that blocks leaves the waiting to the other end, which owns the buffer.
        policy = options.empty_policy
        self._add(
            connector,
            Pulled(source),
            policy if policy is not EmptyPolicy.BLOCK else EmptyPolicy.DO_NOTHING,
        )
        self._notify(ConnectorEvent.CONNECTED, connector)

    def close(self, connector_id: str) -> None:
        """Close a connector; wake its waiting reader or writer.

        What had arrived by the last ones that were closed can still be read.
        """
        with self._lock:
            connector = self._leave(connector_id)
            self._renewals.pop(connector_id, None)
            self._feeds.pop(connector_id, None)
            closed = self._policies.pop(connector_id, None)
            if closed is not None and connector is not None:
                buffer = closed[0]
                buffer.close()
                if not isinstance(buffer, Pulled):
                    self._left = (*self._left, (connector, buffer))
            self._refresh()
        self._notify(ConnectorEvent.DISCONNECTED, connector)

    def _add(
        self, connector: ConnectorProfile, buffer: AnyRing[T] | Pulled[T], policy: EmptyPolicy
    ) -> None:
        with self._lock:
            self._enter(connector)
            self._policies[connector.connector_id] = (buffer, policy)
            self._refresh()

    def _refresh(self) -> None:
        policies = [policy for _, policy in self._policies.values()]
        self._left = tuple(each for each in self._left if len(each[1]))[-_MOST_LEFT:]
        left = (buffer for _, buffer in self._left)
        self._buffers = (*left, *(buffer for buffer, _ in self._policies.values()))
        self._read_from = self._to_read_from()
        self._waits = EmptyPolicy.BLOCK in policies
        self._reads_back = not policies or EmptyPolicy.READBACK in policies

    def _to_read_from(self) -> tuple[Buffer[T], ...]:
        """Return the buffers so that listeners are told what leaves them."""
        if self._listeners is None:
            return self._buffers
        listeners = self._listeners
        left = (NotifyingBuffer(listeners, *each, waits=False) for each in self._left)
        present = (
            NotifyingBuffer(
                listeners, self._profiles[id], buffer, waits=policy is EmptyPolicy.BLOCK
            )
            for id, (buffer, policy) in self._policies.items()
        )
        return (*left, *present)

    def _take_in_turn(self, buffers: tuple[Buffer[T], ...]) -> T | None:
        # After the one read last, so that a connector that floods does not starve the others.
        count = len(buffers)
        for step in range(count):
            index = (self._turn + step) % count
            value = buffers[index].take()
            if value is not None:
                self._turn = index + 1
                return value
        return None

    def _wait(self, buffers: tuple[Buffer[T], ...]) -> T | None:
        for buffer in buffers:
            value = buffer.wait()
            if value is not None:
                return value
        return None

    def _rewire(self) -> None:
        self._refresh()
        has_listeners = self._listener is not None or self._listeners is not None
        for connector_id, (ring, renew) in self._renewals.items():
            renew(self._sink_of(connector_id, ring))
            if isinstance(ring, AwaitedRing):  # a listener is told at once, reader or none
                feed = self._feeds.get(connector_id)
                ring.feed = None if has_listeners else feed

    def _sink_of(self, connector_id: str, ring: AnyRing[T]) -> Sink[T]:
        watch = self._watch
        write = ring.write if watch is None else watch.noting(connector_id, ring)
        if self._listeners is not None:
            write = receiving(self._listeners, self._profiles[connector_id], ring, write)
        return self._with_listener(write)

    def _with_listener(self, write: Sink[T]) -> Sink[T]:
        """Return a sink that calls the listener, if there is one, after each value."""
        listener = self._listener
        if listener is None:
            return write

        def write_and_notify(value: T) -> PortStatus | None:
            refused = write(value)
            listener()
            return refused

        return write_and_notify
