"""Reads and writes values of ports, by a component of its own that is connected for as long."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Generator, Iterable, Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.closing import Closing
from rtkit.errors import Malformed, Refused
from rtkit.link import stopping

if TYPE_CHECKING:
    from rtkit.probe.port_spec import Stream
    from rtkit.probe.tap import Arrival
    from rtkit.rtc.enums import PortType
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


def types_of(streams: Iterable[Stream]) -> dict[str, type]:
    """Return the data type of each stream, by its name.

    Raises:
        RtkitError: One is not known here.
    """
    from rtkit.probe.known_types import data_type

    return {s.name: data_type(s.data_type, s.ends[0].path.typed, s.definition) for s in streams}


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
        from rtkit.component.codec import codec_for
        from rtkit.probe.probe import LOSSLESS, Probe, tap_ports
        from rtkit.rtc.enums import PortType

        streams = _streams(tree, ports, PortType.OUT)
        self._typed = {stream.name: stream.ends[0].path.typed for stream in streams}
        self._decode = {name: codec_for(cls).decode for name, cls in types_of(streams).items()}
        self._arrived: deque[Arrival] = deque()
        self._probe = Probe(tree, "reader", streams, tap_ports(streams))
        try:
            self._probe.connect(LOSSLESS if lossless else {})
        except BaseException:
            self.close()
            raise

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
        while True:
            while self._arrived:
                stream, time_ns, payload = self._arrived.popleft()
                yield PortValue(self._typed[stream], time_ns / 1e9, self._decode[stream](payload))
            with stopping.waking(self._probe.wake):
                piece = self._probe.take(until)
            if piece is None:
                raise Refused("no connection is left: the components or the connections have gone")
            if not piece:
                return
            self._arrived.extend(piece)

    def close(self) -> None:
        """Disconnect."""
        self._probe.close()


def values(
    tree: Tree, ports: Sequence[str], number: int | None, until: float | None, *, lossless: bool
) -> Generator[PortValue | None, None, None]:
    """Yield None when connected, then values of out ports as they come.

    Args:
        tree: The manager of the components.
        ports: Paths of the ports.
        number: How many values; None for no bound.
        until: When to end, monotonic [s]; None for never.
        lossless: Delay the component that writes, rather than lose a value.

    Raises:
        Refused: No connection is left.
    """
    with PortReader(tree, ports, lossless=lossless) as reader:
        yield None
        yield from islice(reader.values(until), number)


def write(tree: Tree, port: str, data: Iterable[Any], rate: float) -> int:
    """Write values to an in port and return how many, once all have arrived.

    Raises:
        Malformed: One is no value of the port's type.
        Refused: No connection is left, or the other end is silent.
    """
    from rtkit.probe.probe import SURE, Probe, out_ports
    from rtkit.rtc.enums import PortType

    streams = _streams(tree, [port], PortType.IN)
    ((name, cls),) = types_of(streams).items()
    count = 0
    with Probe(tree, "writer", streams, out_ports({name: cls})) as probe:
        probe.connect(SURE)
        begin = time.monotonic()
        for count, each in enumerate(data, start=1):
            value = _value(cls, each)
            if not probe.wait(begin + (count - 1) / rate if rate else 0.0):
                raise Refused("no connection is left: the components or the connections have gone")
            stopping.check()
            probe.write(name, value)
        if not probe.flush():
            raise Refused("cannot say whether all values have arrived: the other end is silent")
    return count


def _value(cls: type, given: Any) -> Any:
    """Return what was given as a value of a type; plain data are read as ``rtinject`` does."""
    if isinstance(given, cls):
        return given
    import json

    from rtkit.component.literal import Literal
    from rtkit.component.types import Time

    try:
        text = json.dumps(given)
    except (TypeError, ValueError) as error:
        raise Malformed(f"no value of {cls.__name__}: {given!r}: {error}") from None
    return Literal(cls, text).at(Time.now())


def _streams(tree: Tree, ports: Sequence[str], wanted: PortType) -> tuple[Stream, ...]:
    from rtkit.probe.port_spec import find_streams, parse_spec

    if not ports:
        raise Malformed("No ports specified.")
    return find_streams(tree, [parse_spec(each) for each in ports], wanted)
