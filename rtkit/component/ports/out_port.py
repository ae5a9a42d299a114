"""Out port: values leave from it; part of the data path, used by several threads at once.

Writing is done by the thread that drives the component. Connectors are opened and closed by another
thread, which replaces tuples and never changes one in place.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeVar, cast

from rtkit.component.ports.buffer import AnyRing, Sink, Source, make_ring
from rtkit.component.ports.connector_events import (
    ConnectorEvent,
    buffering,
    give,
    send_buffered,
    sending,
)
from rtkit.component.ports.data_port import DataPort
from rtkit.component.ports.options import EmptyPolicy, PortStatus
from rtkit.errors import Malformed
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import ConnectorProfile

if TYPE_CHECKING:
    from rtkit.component.ports.held_values import HeldValues

T = TypeVar("T")
_OK = PortStatus.OK  # looking a member up in its enumeration would be a tenth of a write


class Queue(Protocol):
    """A keeper of values at an out port until they are sent."""

    def close(self) -> None:
        """Accept no more values and wake whoever waits."""


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
        from rtkit.component.values.carried import test_of

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
        from rtkit.component.values.carried import carried

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
        from rtkit.component.values.carried import test_of

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
        from rtkit.component.ports.held_values import HeldValues

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
