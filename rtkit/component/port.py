"""Ports: exchange values between components; the data path, used by several threads at once.

Writing and reading are done by the thread that drives the component. Connectors are opened and
closed by another thread, which replaces tuples and never changes one in place.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeVar, cast

from rtkit.component.buffer import (
    AnyRing,
    AwaitedRing,
    Buffer,
    BufferFeed,
    Pulled,
    Sink,
    Source,
    make_ring,
)
from rtkit.component.connector_events import (
    ConnectorEvent,
    NotifyingBuffer,
    buffering,
    give,
    receiving,
    send_buffered,
    sending,
)
from rtkit.component.data_port import DataPort
from rtkit.component.options import EmptyPolicy, PortStatus
from rtkit.errors import Malformed
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import ConnectorProfile

if TYPE_CHECKING:
    from rtkit.component.held_values import HeldValues

T = TypeVar("T")
_MOST_LEFT = 64
"""How many closed connectors an in port keeps the unread values of."""
_OK = PortStatus.OK  # looking a member up in its enumeration would be a tenth of a write
Renew = Callable[[Sink[T]], object]
"""Receives the sink to use from now on."""
Listener = Callable[[], None]


class Queue(Protocol):
    """A keeper of values at an out port until they are sent."""

    def close(self) -> None:
        """Accept no more values and wake whoever waits."""


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


class OutPort(DataPort[T]):
    """A port that values leave from.

    Attributes:
        written: Values that were written, whether or not anybody is connected.
    """

    port_type = PortType.OUT
    limit_key = "dataport.fan_out"

    def _begin(self) -> None:
        # The class whose values need no test, the test of others, and the receivers of a value,
        # replaced together while another thread writes.
        self._way: tuple[type | None, Callable[[T], bool], tuple[Sink[T], ...]]
        self._way = (None, self._compile, ())
        self._encoding: set[str] = set()
        self._by_id: dict[str, Sink[T]] = {}
        self._queues: dict[str, Queue] = {}
        self._held: dict[str, HeldValues[T]] = {}
        self.written = 0

    def write(self, value: T) -> PortStatus:
        """Send a value to all connectors; return the last outcome that is not OK, else OK.

        What the writer could change later (arrays, lists, bytearrays) is copied.

        Raises:
            Malformed: The value is not of the port's type, or a field of it holds what does not
                fit; names the field.
        """
        encoded, may_pass, sinks = self._way
        if value.__class__ is not encoded and not may_pass(value):
            value = self._carried(value)
        status = _OK
        failure: Exception | None = None
        for sink in sinks:
            try:
                refused = sink(value)
                if refused is not None:
                    status = refused
            except Exception as error:
                failure = error
        if isinstance(failure, Malformed):  # all encoding sinks do: none was sent
            raise Malformed(f"port {self.name}: {failure}")
        self.written += 1
        if failure is not None:
            raise failure
        return status

    def _compile(self, value: T) -> bool:
        """Compile the test of values at first use, because most ports of a host never write."""
        with self._lock:
            self._find_way()
        return self._way[1](value)

    def _rewire(self) -> None:
        self._find_way()

    def _find_way(self) -> None:
        """Arrange one test a value: here, or in the encoders where all sinks encode at once.

        A test here of values that sinks encode would encode and decode each of them once more.
        """
        from rtkit.component.carried import test_of

        test = test_of(self.data_type)
        # Nobody listens to what may yet be refused, so a test is made here then.
        is_encoded = self._listeners is None and self._encoding.issuperset(self._by_id)
        sinks = tuple(self._notifying(id, sink) for id, sink in self._by_id.items())
        if self._watch is not None:
            sinks = (*sinks, self._watch.note)
        if self._by_id and is_encoded:
            self._way = (self.data_type, self._is_ours, sinks)
        else:
            self._way = (None, test, sinks)

    def _notifying(self, connector_id: str, sink: Sink[T]) -> Sink[T]:
        """Return a sink that tells the listeners, if there are any and the connector is open."""
        connector = self._profiles.get(connector_id)
        if self._listeners is None or connector is None:
            return sink
        queue = self._queues.get(connector_id)
        if queue is None:
            return sending(self._listeners, connector, sink)
        return buffering(self._listeners, connector, queue, sink)

    def _is_ours(self, value: T) -> bool:
        return isinstance(value, self.data_type)

    def _carried(self, value: T) -> T:
        if not isinstance(value, self.data_type):
            raise Malformed(
                f"port {self.name} carries {self.data_type.__name__}, not {type(value).__name__}"
            )
        from rtkit.component.carried import carried

        try:
            return cast(T, carried(self.data_type, value))
        except Malformed as error:
            raise Malformed(f"port {self.name}: {error}") from None

    def attach(
        self,
        connector: ConnectorProfile | str,
        sink: Sink[T],
        *,
        is_encoding: bool = False,
        queue: Queue | None = None,
    ) -> None:
        """Open a push connector, of which the id will do: each value written goes to `sink`.

        A sink that is encoding makes bytes of a value at once, and raises what does not fit. One
        that fills a queue leaves it to `send_notifying` to tell listeners what is sent.

        Raises:
            Refused: It is open already, or the port takes no more.
            Malformed: Values of its type cannot be carried.
        """
        from rtkit.component.carried import test_of

        test_of(self.data_type)  # made here, not in the period of the first value
        if isinstance(connector, str):
            connector = ConnectorProfile(connector, connector, ())
        connector_id = connector.connector_id
        with self._lock:
            self._enter(connector)
            if queue is not None:
                self._queues[connector_id] = queue
            held = self._held.pop(connector_id, None)
            if held is not None:
                held.resume(sink)  # without listeners: they may use the port, which is locked
            self._by_id[connector_id] = sink
            if is_encoding:
                self._encoding.add(connector_id)
            self._find_way()
        self._notify(ConnectorEvent.CONNECTED, connector)

    def send_notifying(self, connector: ConnectorProfile, sink: Sink[T]) -> Sink[T]:
        """Return a sink for what leaves a queue, which tells those who listen by then."""

        def send(value: T) -> PortStatus | None:
            listeners = self._listeners
            if listeners is None:
                return sink(value)
            return send_buffered(listeners, connector, sink, value)

        return send

    def replace(self, connector_id: str, sink: Sink[T]) -> None:
        """Give what is written to another sink from now on; a closed connector stays closed."""
        with self._lock:
            if connector_id in self._by_id:
                self._by_id[connector_id] = sink
                self._find_way()

    def hold(self, connector: ConnectorProfile) -> None:
        """Close a push connector; what is written is kept for the next one of its id."""
        from rtkit.component.held_values import HeldValues

        connector_id = connector.connector_id
        held: HeldValues[T] = HeldValues(self._options(connector).inport)
        with self._lock:
            left = self._leave(connector_id)
            self._encoding.discard(connector_id)
            self._queues.pop(connector_id, None)
            self._by_id[connector_id] = held.write
            self._held[connector_id] = held
            self._find_way()
        self._notify(ConnectorEvent.DISCONNECTED, left)

    def detach(self, connector_id: str) -> None:
        """Close a connector; a write that is under way may still reach it once."""
        with self._lock:
            left = self._leave(connector_id)
            self._held.pop(connector_id, None)
            if self._by_id.pop(connector_id, None) is not None:
                self._encoding.discard(connector_id)
                self._find_way()
            queue = self._queues.pop(connector_id, None)
        if queue is not None:
            queue.close()
        self._notify(ConnectorEvent.DISCONNECTED, left)

    def open_pull(self, connector: ConnectorProfile) -> Source[T]:
        """Open a pull connector; return the source of its values, which waits if the policy does.

        Raises:
            Refused: It is open already, or the port takes no more.
            Malformed: A property of the connector cannot be read.
        """
        options = self._options(connector).outport
        ring: AnyRing[T] = make_ring(options)
        self.attach(connector, ring.write, queue=ring)
        has_waited = options.empty_policy is EmptyPolicy.BLOCK

        def take() -> T | None:
            value = ring.take()
            if value is None:
                value = ring.wait()
            listeners = self._listeners
            if listeners is None:
                return value
            return give(listeners, connector, value, has_waited=has_waited)

        return take
