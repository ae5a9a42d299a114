"""Reads and writes values of ports, by a component of its own that is connected for as long.

Calls operations of service ports, too.
"""

from __future__ import annotations

import json
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.closing import Closing
from rtkit.errors import Malformed, Refused
from rtkit.link import stopping

if TYPE_CHECKING:
    from rtkit.probe.port_spec import PortSpec, Stream
    from rtkit.probe.probe import Probe as Probe
    from rtkit.probe.probe import Refusal
    from rtkit.probe.tap import Arrival
    from rtkit.rtc.enums import PortType
    from rtkit.rtc.names import Path
    from rtkit.rtc.profiles import PortRef
    from rtkit.tree.client import Tree


class NotReached(Refused, TimeoutError):
    """Tells that what was waited for did not come in time."""


class PortValue(NamedTuple):
    """A value that came out of a port.

    Attributes:
        port: As it was named.
        time: When it arrived, Unix time [s].
        value: Of the data type of the port.
    """

    port: str
    time: float
    value: Any


def streams_of(
    tree: Tree,
    ports: Sequence[PortSpec],
    wanted: PortType,
    unnamed: Callable[[int, PortRef], str] | None = None,
    *,
    is_patient: bool = False,
) -> tuple[Stream, ...]:
    """Return the streams of ports that were specified; see `rtkit.probe.port_spec.find_streams`.

    For who is patient a pattern may match nothing as yet.

    Raises:
        RtkitError: One of them is not there or not of that kind.
    """
    from rtkit.component.values.typenames import type_by_name
    from rtkit.probe.port_spec import find_streams
    from rtkit.rtc.data_types import scoped_name
    from rtkit.tree.clock import stamp_clock

    if any(each.is_pattern for each in ports):
        from rtkit.probe.port_pattern import expanded

        found = expanded(tree.snapshot(), ports, wanted, is_patient=is_patient)
        ports = [each for each, _ in found]
    clock = stamp_clock(tree)
    asked = find_streams(tree, ports, wanted, unnamed)
    streams = tuple(each._replace(clock=clock) for each in asked)
    names = [scoped_name(each.data_type) for each in streams if not each.definition]
    if all(type_by_name(name) for name in names if name):
        return streams
    from rtkit.probe.known_types import definitions

    known = definitions(tree.snapshot())
    return tuple(s._replace(elsewhere=known.get(scoped_name(s.data_type), "")) for s in streams)


def streams_at(
    at: Callable[[Path], Tree],
    ports: Sequence[PortSpec],
    wanted: PortType,
    unnamed: Callable[[int, PortRef], str] | None = None,
    *,
    is_patient: bool = False,
) -> tuple[Stream, ...]:
    """Return the streams of ports that may be at several managers; see `streams_of`.

    `at` returns the connection to the manager that a path leads to.

    Raises:
        RtkitError: One of them is not there or not of that kind; or a stream has ports at two
            managers, or one of several is reached over TLS.
    """
    from rtkit.probe.port_spec import STREAMS
    from rtkit.tree.connect import is_behind_tls

    groups: dict[Tree, list[PortSpec]] = {}
    for each in ports:
        groups.setdefault(at(each.path), []).append(each)
    if len(groups) == 1:
        return streams_of(*groups.popitem(), wanted, unnamed, is_patient=is_patient)
    found: dict[str, Stream] = {}
    count = 0

    def name(number: int, ref: PortRef) -> str:
        number += count
        text = unnamed(number, ref) if unnamed is not None else f"{STREAMS[wanted]}{number}"
        while text in found:
            text += "_"
        return text

    for tree, specs in groups.items():
        if is_behind_tls(tree):
            typed = specs[0].path.typed
            raise Refused(f"{typed} is at a manager over TLS: its ports are taken by themselves")
        if is_patient and any(each.is_pattern for each in ports):
            raise Refused("a pattern is followed at one manager: the other ports are at others")
        for stream in streams_of(tree, specs, wanted, name):
            if stream.name in found:
                raise Refused(f"stream {stream.name} has ports at two managers")
            found[stream.name] = stream._replace(tree=tree)
            count += len(stream.ends)
    return tuple(found.values())


def types_of(streams: Iterable[Stream]) -> dict[str, type]:
    """Return the data type of each stream, by its name.

    Raises:
        RtkitError: One is not known here.
    """
    from rtkit.probe.known_types import data_type

    return {s.name: data_type(s.data_type, s.ends[0].path.typed, s.definition) for s in streams}


def reading(
    tree: Tree,
    name: str,
    streams: Sequence[Stream],
    *,
    rate: float = 0.0,
    lossless: bool = False,
    refused: Refusal | None = None,
) -> Probe:
    """Return a component that takes the values of streams from now on; close it to end that.

    Args:
        tree: The manager of the components, of the first ones where there are several.
        name: Of the component, before its number.
        streams: Its ports.
        rate: Take only the newest value this often [Hz]; 0 for all values.
        lossless: Delay the component that writes, rather than lose a value.
        refused: Is told why a port is not connected; it goes on then, as others may come.

    Raises:
        Refused: A connection is not possible.
    """
    from rtkit.probe.probe import LOSSLESS, Probe, tap_ports
    from rtkit.tree.connect import is_behind_tls

    if is_behind_tls(tree):
        from rtkit.probe.far_probe import FarProbe

        probe: Probe = FarProbe(tree, name, streams, rate, writes=False)
    else:
        probe = Probe(tree, name, streams, tap_ports(streams), rate)
    probe.is_patient = refused is not None
    return _connected(probe, LOSSLESS if lossless else {}, refused)


def writing(
    tree: Tree,
    name: str,
    streams: Sequence[Stream],
    types: Mapping[str, type],
    *,
    lossless: bool = False,
) -> Probe:
    """Return a component that writes values of these types to the in ports of streams.

    See `reading`; `lossless` waits where a port has no room for a value.
    """
    from rtkit.probe.probe import LOSSLESS, SURE, Probe, out_ports
    from rtkit.tree.connect import is_behind_tls

    if is_behind_tls(tree):
        from rtkit.probe.far_probe import FarProbe

        probe: Probe = FarProbe(tree, name, streams, 0.0, writes=True)
    else:
        probe = Probe(tree, name, streams, out_ports(types))
    return _connected(probe, LOSSLESS if lossless else SURE)


def _connected(
    probe: Probe, properties: Mapping[str, str], refused: Refusal | None = None
) -> Probe:
    try:
        probe.connect(properties, refused)
    except BaseException:
        probe.close()
        raise
    return probe


class PortReader(Closing):
    """Keeps the values that come out of ports from its beginning on, until they are read.

    Example::

        with PortReader(tree, ["/localhost/Robot0.rtc:pose"]) as pose:
            tree.write("/localhost/Robot0.rtc:goal", {"x": 1.0})
            print(pose.read(timeout_s=5.0))
    """

    def __init__(self, tree: Tree, ports: Sequence[str], *, lossless: bool = False) -> None:
        """Connect to out ports.

        Raises:
            NotFound: A component or a port does not exist.
            Refused: A connection is not possible.
        """
        from rtkit.component.values.codec import codec_for
        from rtkit.rtc.enums import PortType

        tree, streams = _streams(tree, ports, PortType.OUT)
        self._typed = {stream.name: stream.ends[0].path.typed for stream in streams}
        self._decode = {name: codec_for(cls).decode for name, cls in types_of(streams).items()}
        self._arrived: deque[Arrival] = deque()
        self._probe = reading(tree, "reader", streams, lossless=lossless)

    def read(self, *, timeout_s: float) -> Any:
        """Return the next value, which has perhaps come already.

        Args:
            timeout_s: How long to wait for it [s].

        Raises:
            NotReached: None came in time.
            Refused: No connection is left.
        """
        for each in self.values(time.monotonic() + timeout_s):
            return each.value
        raise NotReached(f"{', '.join(self._typed.values())} carried no data for {timeout_s:g} s")

    def values(self, until: float | None) -> Iterator[PortValue]:
        """Yield values as they come, until a moment [s, monotonic].

        Raises:
            Refused: No connection is left.
        """
        from rtkit.probe.probe import no_connection

        while True:
            while self._arrived:
                stream, time_ns, payload = self._arrived.popleft()
                yield PortValue(self._typed[stream], time_ns / 1e9, self._decode[stream](payload))
            with stopping.waking(self._probe.wake):
                piece = self._probe.take(until)
            if piece is None:
                raise no_connection()
            if not piece:
                return
            self._arrived.extend(piece)

    def close(self) -> None:
        """Disconnect."""
        self._probe.close()


def values(
    tree: Tree, ports: Sequence[str], number: int | None, until: float | None, *, lossless: bool
) -> Generator[PortValue | None, None, None]:
    """Yield None when connected, then what `rtkit.Tree.values` yields, until a moment [s]."""
    with PortReader(tree, ports, lossless=lossless) as reader:
        yield None
        yield from islice(reader.values(until), number)


def write(tree: Tree, port: str, data: Iterable[Any], rate: float) -> int:
    """Write values to an in port and return how many; see `rtkit.Tree.write`."""
    from rtkit.rtc.enums import PortType

    tree, streams = _streams(tree, [port], PortType.IN)
    types = types_of(streams)
    count = 0
    with writing(tree, "writer", streams, types) as probe:
        begin = time.monotonic()
        for count, each in enumerate(data, start=1):
            values = {name: _value(cls, each) for name, cls in types.items()}
            probe.wait(begin + (count - 1) / rate if rate else 0.0)
            stopping.check()
            for name, value in values.items():
                probe.write(name, value)
        probe.flush()
    return count


def _value(cls: type, given: Any) -> Any:
    """Return what was given as a value of a type; plain data are read as ``rtinject`` does."""
    if isinstance(given, cls):
        return given
    from rtkit.component.types import Time
    from rtkit.component.values.literal import Literal

    try:
        text = json.dumps(given)
    except (TypeError, ValueError) as error:
        raise Malformed(f"no value of {cls.__name__}: {given!r}: {error}") from None
    return Literal(cls, text).at(Time.now())


def _streams(tree: Tree, ports: Sequence[str], wanted: PortType) -> tuple[Tree, tuple[Stream, ...]]:
    """Return the streams of ports, and the connection to the manager of the first one."""
    from rtkit.probe.port_spec import parse_spec

    if not ports:
        raise Malformed("No ports specified.")
    specs = [parse_spec(each) for each in ports]
    return tree.led_to(specs[0].path), streams_at(tree.led_to, specs, wanted)


def call(tree: Tree, typed: str, arguments: Sequence[Any], timeout_s: float) -> Any:
    """Call an operation of a service port; see `rtkit.Tree.call`."""
    from rtkit.probe.calling import chosen, operations_at
    from rtkit.rtc.names import parse_path

    path = parse_path(typed)
    if path.port is None:
        raise Malformed(f"No port specified: {typed} (it is COMPONENT:PORT.OPERATION)")
    tree = tree.led_to(path)
    operations, name = operations_at(tree, path)
    operation = chosen(operations, name)
    found = operation.call(
        tree, operation.arguments([_text(each) for each in arguments]), timeout_s
    )
    return found.get("") if found.keys() <= {""} else found


def _text(value: Any) -> str:
    """Return a value as the text that is typed for it; a text is it already."""
    from rtkit.component.values.value_text import plain

    return value if isinstance(value, str) else json.dumps(plain(value))
