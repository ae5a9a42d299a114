"""Runs a tool's temporary component in an attached process, connected to the named ports.

See decision 15.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any
from uuid import uuid4

from rtkit.closing import Closing
from rtkit.component.base import Component
from rtkit.component.contexts.owned_contexts import PERIODIC
from rtkit.component.ports.any_port import Port
from rtkit.component.ports.options import NUMBERED, PortStatus
from rtkit.component.ports.out_port import OutPort
from rtkit.container.attached_process import ENTERING, AttachedProcess, attached_to, leave_if_empty
from rtkit.deployment.actions import Action, ChangeState, Connect
from rtkit.errors import Refused, RtkitError, from_kind
from rtkit.link import stopping
from rtkit.probe.backlog import Backlog
from rtkit.probe.port_spec import Stream
from rtkit.probe.tap import Arrival, Tap
from rtkit.rtc.enums import Transition
from rtkit.rtc.far_ends import named_by, on_host
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree
from rtkit.tree.connect import near_of
from rtkit.tree.expecting import expected
from rtkit.tree.wiring import ResolvedPort, make_connector

_TRIES = 20
_FLUSH_S = 5.0
SURE = {"dataport.outport.buffer.write.full_policy": "block"}
"""Connector properties by which a writer waits where the transport would drop a value."""
LOSSLESS = {
    "dataport.inport.buffer.write.full_policy": "block",
    "dataport.inport.buffer.write.timeout": "60",
}
"""Connector properties by which a slow reader delays its writer and loses nothing."""

Refusal = Callable[[str], object]
_Connect = tuple[str, ConnectorProfile]


class Tool(Component):
    """A tool's end of connections.

    Attributes:
        arrived: Arrived values, in batches.
        notify: Called when something has.
    """

    vendor = "rtkit"
    category = "tool"
    execution_type = "EventDrivenExecutionContext"

    def __init__(self, instance: str, ports: Sequence[Port], rate: float) -> None:
        polling = {"exec_cxt.periodic.type": PERIODIC, "exec_cxt.periodic.rate": repr(rate)}
        super().__init__(instance, polling if rate else {})
        self._is_polling = rate > 0
        self.arrived: queue.SimpleQueue[list[Arrival]] = queue.SimpleQueue()
        self._taps: list[Tap] = []
        self.notify: Callable[[], object] = lambda: None
        self.extend(ports)

    def extend(self, ports: Sequence[Port]) -> None:
        """Add ports."""
        for port in ports:
            self._add(port)
        self._taps = [*self._taps, *(port for port in ports if isinstance(port, Tap))]

    def on_execute(self, context: str) -> None:
        """Hand the arrived values over, in one batch."""
        if self._is_polling:
            arrivals = [tap.take()[-1] for tap in self._taps if tap.is_new()]
        else:
            arrivals = [arrival for tap in self._taps for arrival in tap.take()]
        if arrivals:
            self.arrived.put(arrivals)
            self.notify()


class Probe(Closing):
    """An attached process with one component of a tool; use as a context manager to end it.

    With a rate [Hz] the component takes the newest value of each port that often; else all values,
    as they arrive.

    Attributes:
        component: The tool's component.
        is_patient: Whether it goes on without connections, as others may come.
    """

    _backlog: Backlog | None = None
    _taken: Sequence[Arrival] = ()

    def __init__(
        self,
        tree: Tree,
        kind: str,
        streams: Sequence[Stream],
        ports: Sequence[Port],
        rate: float = 0.0,
    ) -> None:
        self._tree = tree
        self._home = near_of(tree)
        self._kind = kind
        self._streams = streams
        self._ports = ports
        self._rate = rate
        self._properties: Mapping[str, str] = {}
        self.is_patient = False
        self._ended = threading.Event()
        self._attached, self.component = self._attach()

    def connect(self, properties: Mapping[str, str], refused: Refusal | None = None) -> None:
        """Activate the component and connect its ports.

        Args:
            properties: Of the connectors.
            refused: Is told why a port is not connected, and the others are; without it that ends
                all.

        Raises:
            Refused: A connection is not possible, or failed; names the port as typed.
        """
        self._properties = properties
        if not self._rate:
            self._backlog = Backlog(is_lossless=properties == LOSSLESS)
            self._bound(self._ports)
        self._attached.listeners.append(self._look)
        activate = ChangeState(self.component.instance, "0", Transition.ACTIVATE)
        groups: dict[Tree, list[Stream]] = {}
        for stream in self._streams:
            groups.setdefault(stream.tree or self._tree, []).append(stream)
        connects = {t: list(self._connects(t, each, refused)) for t, each in groups.items()}
        _perform(self._home, [("", activate)], None)
        for tree, each in connects.items():
            self._connect(tree, each, refused)

    def extend(self, ports: Sequence[Port]) -> None:
        """Give the component further ports; the manager knows them a little later."""
        self._bound(ports)
        self._attached.change(self.component, lambda: self.component.extend(ports))

    def _bound(self, ports: Iterable[Port]) -> None:
        for port in ports:
            if isinstance(port, Tap):
                port.backlog = self._backlog

    def join(self, tree: Tree, streams: Sequence[Stream], refused: Refusal) -> None:
        """Connect further streams, by a connection to the present manager; see `connect`."""
        self._connect(tree, self._connects(tree, streams, refused), refused)

    def _connect(self, tree: Tree, connects: Iterable[_Connect], refused: Refusal | None) -> None:
        named = list(connects)
        if self._is_home(tree):
            _perform(tree, [(typed, Connect(each)) for typed, each in named], refused)
            return
        for typed, connector in named:  # the manager of the out end makes it
            ends = (self._home, tree)
            is_mine = connector.ports[0].instance == self.component.instance
            maker, other = ends if is_mine else ends[::-1]
            between = named_by(connector, on_host(maker.manager, maker.host))
            with expected([(other, between)] if maker.host != other.host else []) as failed:
                if not _perform(maker, [(typed, Connect(connector))], refused):
                    failed.append(connector.connector_id)

    def _is_home(self, tree: Tree) -> bool:
        return (tree.manager, tree.host) == (self._home.manager, self._home.host)

    def _connects(
        self, tree: Tree, streams: Sequence[Stream], refused: Refusal | None
    ) -> Iterator[_Connect]:
        """Yield the connector of each port, with the port as typed."""
        own, far = "", ""
        if not self._is_home(tree):
            own = on_host(self._home.manager, self._home.host)
            far = on_host(tree.manager, tree.host)
        given = {NUMBERED: "YES", **self._properties}
        for stream in streams:
            port = self.component.ports[stream.name].profile
            ref = PortRef(self.component.instance, stream.name)
            mine = ResolvedPort(stream.ends[0].path, ref, port, own)
            for end in stream.ends:
                try:
                    there = end._replace(manager=far)
                    connector = make_connector(mine, there, str(uuid4()), "", given)
                except RtkitError as error:
                    if refused is None:
                        raise
                    refused(f"{end.path.typed}: {error}")
                    continue
                yield end.path.typed, connector

    @property
    def lost(self) -> int:
        """Number of values that were sent to it and are not among its arrivals."""
        self._let_in()
        taps = (port for port in self._ports if isinstance(port, Tap))
        return self._attached.lost() + sum(tap.lost for tap in taps)

    def check_connected(self) -> None:
        """Check that any connection remains.

        Raises:
            Refused: None does.
        """
        if not any(port.connectors for port in self._ports):
            raise no_connection()

    def arrivals(self, until: float | None) -> Iterator[list[Arrival]]:
        """Yield arrivals in batches until a monotonic time [s], or until nothing can arrive.

        Nothing can when its connections were removed, or the component was ended from outside.
        """
        while piece := self.take(until):
            yield piece

    def take(self, until: float | None) -> list[Arrival] | None:
        """Wait for arrivals until that time [s]; return None when nothing can arrive any more.

        The values of the call before have been dealt with.
        """
        arrived = self.component.arrived
        if self._backlog is not None:
            self._backlog.leave(arrival.payload for arrival in self._taken)
            self._taken = ()
        while not (self._ended.is_set() and arrived.empty()):
            wait_s = None if until is None else max(0.0, until - time.monotonic())
            try:
                piece = arrived.get(timeout=wait_s)
            except queue.Empty:
                return []
            stopping.check()
            if piece:
                self._taken = piece if self._backlog is not None else ()
                return piece
        return None

    def _let_in(self) -> None:
        if self._backlog is not None:
            self._backlog.open()

    def wake(self) -> None:
        """Wake the waiting thread, which goes on to wait unless a stop was requested."""
        self.component.arrived.put([])

    def wait(self, until: float) -> None:
        """Wait until a monotonic time [s].

        Raises:
            Refused: No connection is left to write to.
        """
        if self._ended.wait(max(0.0, until - time.monotonic())):
            raise no_connection()

    def write(self, port: str, value: Any) -> None:
        """Write a value to one of its out ports.

        Raises:
            Refused: It was not taken.
        """
        own = self.component.ports[port]
        status = own.write(value) if isinstance(own, OutPort) else PortStatus.ERROR
        if status is not PortStatus.OK:
            raise Refused(f"value not taken: {status}")

    def flush(self) -> None:
        """Wait until all written values have arrived.

        Raises:
            Refused: That is not certain.
        """
        if not self._attached.flush(_FLUSH_S):
            raise Refused("cannot say whether all values have arrived: the other end is silent")

    def stop(self) -> None:
        """End the arrivals and wake the waiting thread; may be called on any thread."""
        self._ended.set()
        self._let_in()
        self.component.arrived.put([])
        self.component.notify()

    def close(self) -> None:
        """End the component and detach the process."""
        self._let_in()
        if self._look in self._attached.listeners:
            self._attached.listeners.remove(self._look)
        self._attached.end([self.component.instance])
        leave_if_empty(self._attached)

    def _attach(self) -> tuple[AttachedProcess, Tool]:
        """Attach under the first free name."""
        taken = {row.instance for row in self._home.listing().rows}
        error: RtkitError | None = None
        for number in range(_TRIES + len(taken)):
            name = f"{self._kind}{number}"
            if name in taken:
                continue
            component = Tool(name, self._ports, self._rate)
            where = (self._home.manager, self._home.host, self._kind)
            with ENTERING:
                attached = attached_to(*where, prepare=lambda _: None)
                try:
                    attached.enter([component], self._tree.timeout_s)
                    return attached, component
                except RtkitError as refused:
                    attached.end([name])
                    leave_if_empty(attached)
                    if not isinstance(refused, Refused):
                        raise
                    error = refused  # another process took the name in the meantime
        raise error or Refused(f"no name is free for {self._kind}")

    def _look(self) -> None:
        is_connected = any(port.connectors for port in self._ports)
        if not (self._attached.holds and (self.is_patient or is_connected)):
            self.stop()


def no_connection() -> Refused:
    """Return the error that nothing is connected any more."""
    return Refused("no connection is left: the components or the connections have gone")


def _perform(tree: Tree, named: Sequence[tuple[str, Action]], refused: Refusal | None) -> bool:
    """Perform actions, in order unless failures of some are only told; return whether all were."""
    results = tree.apply([action for _, action in named], is_ordered=refused is None)
    for (typed, _), result in zip(named, results, strict=False):
        if not result.ok:
            error = from_kind(result.kind, f"{typed}: {result.why}" if typed else result.why)
            if refused is None:
                raise error
            refused(str(error))
    return all(result.ok for result in results)


def tap_ports(streams: Sequence[Stream]) -> list[Tap]:
    """Return a port for each stream, whose buffer counts dropped values."""
    counted = {
        "dataport.inport.buffer.length": "4096",
        "dataport.inport.buffer.read.empty_policy": "block",
    }
    return [Tap(stream.name, counted) for stream in streams]


def out_ports(types: Mapping[str, type]) -> list[OutPort[Any]]:
    """Return an out port for each stream, by name and data type."""
    return [OutPort(data_type, name) for name, data_type in types.items()]
