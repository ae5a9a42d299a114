"""Joins ports: directly inside a process, by a stream between two.

The component cannot tell which it is. Threads exist only for publishers of their own rate.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary, ref

from rtkit.component.contexts.period import Period
from rtkit.component.contexts.waiting import waiting
from rtkit.component.ports.buffer import AnyRing, Sink, Source, make_ring, select
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.options import (
    NUMBERED,
    ConnectorOptions,
    FullPolicy,
    PortStatus,
    PushPolicy,
    parse_options,
)
from rtkit.component.ports.out_port import OutPort
from rtkit.component.values.carried import passage
from rtkit.component.values.codec import codec_for, encoder_for, splitter_for
from rtkit.errors import Malformed
from rtkit.link import zenoh_keys
from rtkit.link.ends import (
    CallerEnd,
    ConnectorEnd,
    Fetcher,
    Inlet,
    Octets,
    Outlet,
    Payload,
    Streams,
)
from rtkit.link.threads import start_thread
from rtkit.logs.late import late
from rtkit.rtc.far_ends import host_of, own_end, peer_of
from rtkit.rtc.profiles import ConnectorProfile

MATCH_S = 5.0
"""How long a sender looks for its receiver [s]."""

if TYPE_CHECKING:
    from rtkit.link.routed_streams import StreamsByRouter

_log = late(__name__)


class PortWiring:
    """Connector ends of one process.

    Args:
        host: Name of this host.
        streams: To other processes of it.
        manager: Manager whose router passes on data from and to other hosts.
    """

    def __init__(self, host: str, streams: Streams, manager: str = "") -> None:
        self._host = host
        self._near = streams
        self._manager = manager
        self._far: StreamsByRouter | None = None
        streams.report = lambda text: _log().warning("%s", text)
        self._ends: dict[str, list[ConnectorEnd]] = {}
        self._encoders: WeakKeyDictionary[OutPort[Any], dict[bool, EncodedOnce]] = (
            WeakKeyDictionary()
        )

    def join(self, connector: ConnectorProfile, out: OutPort[Any], into: InPort[Any]) -> None:
        """Connect two ports of this process; values that nobody can change are handed over."""
        options = parse_options(connector.properties)
        change = passage(
            out.data_type, into.data_type_for(connector), is_big_endian=options.is_big_endian
        )
        if options.dataflow == "pull":
            source = out.open_pull(connector)
            with _undone(lambda: out.detach(connector.connector_id)):
                into.open_pull(connector, _changed(source, change))
            return
        id = connector.connector_id
        if _is_wrapped(options):
            sink = _present_sink(into, connector)
            with _undone(lambda: into.close(id)):
                self._attach(connector, out, _changing(sink, change, id), options)
            return
        sink = into.open(connector, lambda sink: out.replace(id, _changing(sink, change, id)))
        with _undone(lambda: into.close(id)):
            out.attach(connector, _changing(sink, change, id))
        into.renew(id)

    def receive(self, connector: ConnectorProfile, into: InPort[Any]) -> str:
        """Open the receiving end of a stream and return its endpoint."""
        sink = _present_sink(into, connector)
        id, options = connector.connector_id, parse_options(connector.properties)
        decode = codec_for(into.data_type_for(connector)).decode
        deliver = _changing(sink, None if into.is_undecoded else decode, id)
        with _undone(lambda: into.close(id)):
            endpoint, inlet = self._streams(connector).receive(
                self._key(connector, 1),
                deliver,
                is_patient=options.inport.full_policy is FullPolicy.BLOCK,
            )
        into.feed(id, inlet)
        self.keep(connector, inlet)
        return endpoint

    def serve(self, connector: ConnectorProfile, out: OutPort[Any]) -> str:
        """Open the end of a pull connector that is asked, and return its endpoint."""
        options = parse_options(connector.properties)
        encode = encoder_for(out.data_type, is_big_endian=options.is_big_endian)
        next_value = _changed(out.open_pull(connector), encode)
        with _undone(lambda: out.detach(connector.connector_id)):
            endpoint, inlet = self._streams(connector).answer(self._key(connector, 0), next_value)
        self.keep(connector, inlet)
        return endpoint

    def find_receiver(self, connector: ConnectorProfile, endpoint: str) -> Outlet:
        """Reach for the receiving end; on a thread of its own, because it may be stopped."""
        options = parse_options(connector.properties)
        policies = (options.inport.full_policy, options.outport.full_policy)
        return self._streams(connector).send(
            endpoint,
            self._key(connector, 1),
            MATCH_S,
            is_blocking=FullPolicy.BLOCK in policies,
            is_numbered=connector.properties.get(NUMBERED, "").upper() == "YES",
        )

    def send(self, connector: ConnectorProfile, out: OutPort[Any], outlet: Outlet) -> None:
        """Have a port send to the receiving end that was found."""
        options = parse_options(connector.properties)
        encode = self._encoder(out, is_big_endian=options.is_big_endian)
        put, offer, patience_s = outlet.put, outlet.offer, outlet.patience_s

        def write(value: Any) -> PortStatus | None:
            return None if put(encode(value)) else PortStatus.CONNECTION_LOST

        def write_patiently(value: Any) -> PortStatus | None:
            octets = encode(value)
            if offer(octets):
                return None
            with waiting(patience_s):
                return None if put(octets) else PortStatus.CONNECTION_LOST

        sink = write_patiently if patience_s else write
        self._attach(connector, out, sink, options, is_encoding=True)
        self.keep(connector, outlet)
        encode.users += 1
        self.keep(connector, encode)

    def _encoder(self, out: OutPort[Any], *, is_big_endian: bool) -> EncodedOnce:
        """Return the encoder of all connectors of a port that want one order of bytes."""
        split = splitter_for(out.data_type, is_big_endian=is_big_endian)
        by_order = self._encoders.setdefault(out, {})
        return by_order.setdefault(is_big_endian, EncodedOnce(out, split))

    def find_source(self, connector: ConnectorProfile, endpoint: str) -> Fetcher:
        """Reach for the end of a pull connector that is asked; on a thread of its own."""
        return self._streams(connector).ask(endpoint, self._key(connector, 0), MATCH_S)

    def fetch(self, connector: ConnectorProfile, into: InPort[Any], fetcher: Fetcher) -> None:
        """Have a port ask the end that was found."""
        options = parse_options(connector.properties)
        decode = codec_for(into.data_type_for(connector)).decode
        bound_s = options.inport.read_timeout + options.outport.read_timeout

        def fetch() -> Octets | None:
            with waiting(bound_s):
                return fetcher.fetch(bound_s)

        into.open_pull(connector, _changed(fetch, decode))
        self.keep(connector, fetcher)

    def serve_calls(
        self, connector: ConnectorProfile, end: int, reply_to: Callable[[bytes], bytes]
    ) -> str:
        """Open the end of a service connector that is called, and return its endpoint."""
        key = f"{self._key(connector, end)}/{end}"
        endpoint, called = self._streams(connector).serve(key, reply_to)
        self.keep(connector, called)
        return endpoint

    def find_provider(self, connector: ConnectorProfile, end: int, endpoint: str) -> CallerEnd:
        """Reach for the end of a service connector that is called; on a thread of its own."""
        key = f"{self._key(connector, end)}/{end}"
        return self._streams(connector).caller(endpoint, key, MATCH_S)

    def flush(self, timeout_s: float) -> bool:
        """Wait until all that was sent has arrived; False when that is not known in time."""
        until = time.monotonic() + timeout_s
        outlets = [end for end in self._all_ends() if isinstance(end, Outlet)]
        return all(outlet.flush(max(0.0, until - time.monotonic())) for outlet in outlets)

    def lost(self, timeout_s: float) -> int:
        """Return how many values were sent to this process on numbered streams and not received.

        Senders are asked what they have sent, for so long at most [s].
        """
        until = time.monotonic() + timeout_s
        inlets = [end for end in self._all_ends() if isinstance(end, Inlet)]
        for inlet in inlets:
            inlet.settle(max(0.0, until - time.monotonic()))
        return sum(inlet.lost for inlet in inlets)

    def _all_ends(self) -> list[ConnectorEnd]:
        return [end for ends in list(self._ends.values()) for end in ends]

    def send_rest(self, connector_id: str, timeout_s: float) -> None:
        """Send what publishers of a connector still have, and wait until all has arrived.

        Each of both may take so long at most [s].
        """
        ends = list(self._ends.get(connector_id, ()))
        for end in ends:
            if isinstance(end, _Publisher):
                end.finish(timeout_s)
        for end in ends:
            if isinstance(end, Outlet):
                end.flush(timeout_s)

    def cut(self, connector_id: str) -> None:
        """Close what this process holds of a connector."""
        for end in self._ends.pop(connector_id, ()):
            end.close()

    def close(self) -> None:
        """Close everything."""
        for connector_id in list(self._ends):
            self.cut(connector_id)
        self._near.close()
        if self._far is not None:
            self._far.close()

    def _attach(
        self,
        connector: ConnectorProfile,
        out: OutPort[Any],
        sink: Sink[Any],
        options: ConnectorOptions,
        *,
        is_encoding: bool = False,
    ) -> None:
        if options.subscription == "periodic":
            sink = out.send_notifying(connector, sink)
            publisher = _Publisher(connector.connector_id, sink, options)
            with _undone(publisher.close):
                out.attach(connector, publisher.write, queue=publisher.ring)
            self.keep(connector, publisher)
        elif _is_wrapped(options):
            group = _Group(out.send_notifying(connector, sink), options.skip_count + 1)
            out.attach(connector, group.write, queue=group)
        else:
            out.attach(connector, sink, is_encoding=is_encoding)

    def keep(self, connector: ConnectorProfile, end: ConnectorEnd) -> None:
        """Have an end closed when its connector is cut."""
        self._ends.setdefault(connector.connector_id, []).append(end)

    def _streams(self, connector: ConnectorProfile) -> Streams:
        host = host_of(peer_of(connector))
        if not host:
            return self._near
        if self._far is None:
            # The library of that way is large: most processes have no connector between hosts.
            from rtkit.link.routed_streams import StreamsByRouter

            self._far = StreamsByRouter(self._manager)
        return self._far.to(host)

    def _key(self, connector: ConnectorProfile, listening: int) -> str:
        """Return the key of a connector's data; its end `listening` is the one waited at."""
        other = host_of(peer_of(connector))
        if not other:
            return zenoh_keys.data(self._host, connector.connector_id)
        is_here = own_end(connector)[0] == listening
        ways = (self._host, other) if is_here else (other, self._host)
        return zenoh_keys.far_data(*ways, connector.connector_id)


@contextmanager
def _undone(undo: Callable[[], object]) -> Iterator[None]:
    """Take back what was done before, when what is done inside fails."""
    try:
        yield
    except Exception:
        undo()
        raise


class EncodedOnce:
    """Encodes a value for all connectors of a port that it is written to.

    Args:
        out: The port; each of its writes has a number of its own.
        encode: Encodes a value.

    Attributes:
        users: How many connectors use it.
    """

    def __init__(self, out: OutPort[Any], encode: Callable[[Any], Payload]) -> None:
        self._out = ref(out)
        self._encode = encode
        self._value: Any = None
        self._made: Payload = b""
        self._write = -1
        self.users = 0

    def __call__(self, value: Any) -> Payload:
        """Return the encoding."""
        out = self._out() if self.users > 1 else None
        if out is None:
            return self._encode(value)
        if value is not self._value or out.written != self._write:
            self._made = self._encode(value)
            self._value, self._write = value, out.written
        return self._made

    def close(self) -> None:
        """Note that a connector uses it no more."""
        self.users -= 1
        self._value, self._made = None, b""


def _is_wrapped(options: ConnectorOptions) -> bool:
    """Return whether something stands between a port and the sink that it writes to."""
    skips = options.push_policy is PushPolicy.SKIP and options.skip_count > 0
    return skips or options.subscription == "periodic"


def _changing(sink: Sink[Any], change: Callable[[Any], Any] | None, name: str) -> Sink[Any]:
    """Return a sink that gives on what `change` makes of a value, if it is a value of the reader's.

    No writer knows of the others: it wrote a value of its own type.
    """
    if change is None:
        return sink

    def write(value: Any) -> PortStatus | None:
        try:
            changed = change(value)
        except Malformed as error:
            _log().warning("%s: value dropped: %s", name, error)
            return None
        return sink(changed)

    return write


def _changed(source: Source[Any], change: Callable[[Any], Any] | None) -> Source[Any]:
    """Return a source of what `change` makes of each value."""
    if change is None:
        return source

    def take() -> Any:
        value = source()
        return None if value is None else change(value)

    return take


def _present_sink(into: InPort[Any], connector: ConnectorProfile) -> Sink[Any]:
    """Open a connector; return what gives a value to the sink that the port names at present."""
    sinks: list[Sink[Any]] = []

    def renew(sink: Sink[Any]) -> None:
        sinks[:] = [sink]

    renew(into.open(connector, renew))
    into.renew(connector.connector_id)
    return lambda value: sinks[0](value)


class _Group:
    """Lets the last of each `size` values through."""

    def __init__(self, sink: Sink[Any], size: int) -> None:
        self._sink = sink
        self._size = size
        self._count = 0

    def write(self, value: Any) -> PortStatus | None:
        """Take a value."""
        self._count += 1
        return self._sink(value) if self._count % self._size == 0 else None

    def close(self) -> None:
        """Do nothing: nobody waits here."""


class _Publisher:
    """Sends from a buffer at a rate of its own (subscription type ``periodic``)."""

    def __init__(self, name: str, sink: Sink[Any], options: ConnectorOptions) -> None:
        self._name = name
        self.ring: AnyRing[Any] = make_ring(options.outport)
        self._sink = sink
        self._options = options
        self._closed = threading.Event()
        self.write: Sink[Any] = self.ring.write
        self._thread = start_thread(self._run, f"publish {name}")

    def close(self) -> None:
        """Send nothing more."""
        self._closed.set()
        self.ring.close()

    def finish(self, timeout_s: float) -> None:
        """Send what its policy would send of what is left, at once; then nothing more."""
        self._closed.set()
        self._thread.join(timeout_s)
        options = self._options
        while values := select(options.push_policy, self.ring, options.skip_count):
            for value in values:
                self._send(value)

    def _run(self) -> None:
        options = self._options
        period = Period(options.push_rate, time.monotonic_ns())
        while not self._closed.wait(period.wait_s(time.monotonic_ns())):
            for value in select(options.push_policy, self.ring, options.skip_count):
                self._send(value)
            period.advance(time.monotonic_ns())

    def _send(self, value: Any) -> None:
        try:
            self._sink(value)
        except Malformed as error:
            _log().warning("%s: value not sent: %s", self._name, error)
