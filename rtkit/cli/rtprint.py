"""``rtprint``: print the values that come out of ports."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import click

from rtkit.cli import _records
from rtkit.cli._app import App, command
from rtkit.cli._data import module_options, named_streams
from rtkit.errors import Refused

if TYPE_CHECKING:
    from rtkit.probe.spec import Stream
    from rtkit.probe.tap import Arrival

Line = Callable[["Arrival"], str]


@command("rtprint")
@click.option(
    "-n", "--number", type=click.IntRange(min=1), metavar="N", help="Stop after N values."
)
@click.option(
    "-r",
    "--rate",
    type=click.FloatRange(min=0.0, min_open=True, max=100_000),
    metavar="HZ",
    help="Look this often and take at most one value of each port; -n then counts looks.",
)
@click.option(
    "-t",
    "--timeout",
    "duration_s",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="SECONDS",
    help="Stop after this time; -n then has no effect.",
)
@module_options
@click.option(
    "-f",
    "--field",
    "fields",
    multiple=True,
    metavar="FIELD",
    help="Print only data.x (repeatable).",
)
@click.option("--full", "is_full", is_flag=True, help="Do not shorten long contents.")
@click.option(
    "--stats", "is_stats", is_flag=True, help="Print no values but how they came, at the end."
)
@click.option("--json", "is_json", is_flag=True, help="One JSON object a line.")
@click.option(
    "--lossless", is_flag=True, help="Rather hold up the component that writes than lose a value."
)
@click.argument("ports", nargs=-1, metavar="PORT[.STREAM][#FORMATTER]...")
def main(
    app: App,
    ports: tuple[str, ...],
    number: int | None,
    rate: float | None,
    duration_s: float | None,
    modules: tuple[str, ...],
    folders: tuple[str, ...],
    fields: tuple[str, ...],
    is_full: bool,
    is_stats: bool,
    is_json: bool,
    lossless: bool,
) -> int:
    """Print the values that come out of ports, as they come.

    It ends after N values, after some time, or when its connections are gone. The status is 1
    when nothing came at all. While it runs a component of its own, rtprint_reader0, is connected
    to the ports.

    A value of nothing but a time stamp and data is printed as [seconds] data. FORMATTER is a
    function of one argument, MODULE.NAME, or rawpy for the full text of every value.

    With --stats: how many values came, their rate, the intervals between them with the standard
    deviation as jitter, their size in CDR, and their age on arrival by their time stamps.
    """
    from rtkit.probe.probe import LOSSLESS, Probe, tap_ports
    from rtkit.probe.types import import_modules
    from rtkit.rtc.enums import PortType

    import_modules(modules, folders)
    streams = named_streams(app, ports, PortType.OUT)
    sink = _Counter(streams) if is_stats else _Printer(streams, fields, is_full, is_json)
    until = None if duration_s is None else time.monotonic() + duration_s
    limit = None if duration_s is not None else number
    with Probe(app.tree, "rtprint_reader", streams, tap_ports(streams), rate or 0.0) as probe:
        probe.connect(LOSSLESS if lossless else {})
        app.tell(f"{probe.component.instance} is connected")
        for piece in _limited(probe.arrivals(until), limit, is_by_piece=rate is not None):
            sink.take(piece)
        lost = probe.lost
        is_cut = not probe.is_connected
    sink.finish(is_json, lost)
    if lost:
        app.say(f"{app.name}: {lost} values were lost")
    if is_cut:
        raise Refused("no connection is left: the components or the connections have gone")
    return 0 if sink.count else 1


class _Printer:
    """Prints every value."""

    def __init__(
        self, streams: tuple[Stream, ...], fields: tuple[str, ...], is_full: bool, is_json: bool
    ) -> None:
        self._lines = _lines(streams, fields, is_full=is_full, is_json=is_json)
        self.count = 0

    def take(self, piece: list[Arrival]) -> None:
        self.count += len(piece)
        sys.stdout.write("".join(f"{self._lines[each.stream](each)}\n" for each in piece))
        sys.stdout.flush()

    def finish(self, is_json: bool, lost: int) -> None:
        """Do nothing: all is printed."""


class _Counter:
    """Tells at the end how values came."""

    def __init__(self, streams: tuple[Stream, ...]) -> None:
        from rtkit.probe.stats import Stats, stamp_reader
        from rtkit.probe.types import data_type

        self._streams = streams
        self._stats = {
            each.name: Stats(stamp_reader(data_type(each.data_type, each.ends[0].path.typed)))
            for each in streams
        }

    @property
    def count(self) -> int:
        return sum(stats.count for stats in self._stats.values())

    def take(self, piece: list[Arrival]) -> None:
        for arrival in piece:
            self._stats[arrival.stream].take(arrival)

    def finish(self, is_json: bool, lost: int) -> None:
        from rtkit.cli._out import printable, write
        from rtkit.probe.report import lines_of, record_of

        for stream in self._streams:
            told = self._stats[stream.name].summary()
            if is_json:
                write([_records.line("stream-stats", record_of(stream, told, lost))])
            else:
                write(map(printable, lines_of(stream, told)))


def _limited(
    pieces: Iterator[list[Arrival]], limit: int | None, *, is_by_piece: bool
) -> Iterator[list[Arrival]]:
    """Yield pieces until there were so many of them, or of their values."""
    left = limit
    for piece in pieces:
        taken = piece if left is None or is_by_piece else piece[:left]
        yield taken
        if left is not None:
            left -= 1 if is_by_piece else len(taken)
            if left <= 0:
                return


def _lines(
    streams: tuple[Stream, ...], fields: tuple[str, ...], *, is_full: bool, is_json: bool
) -> dict[str, Line]:
    """Return what makes a line of an arrival, by stream."""
    from rtkit.component.codec import codec_for
    from rtkit.probe.types import data_type

    made: dict[str, Line] = {}
    for stream in streams:
        decode = codec_for(data_type(stream.data_type, stream.ends[0].path.typed)).decode
        if is_json:
            made[stream.name] = _json_line(stream, decode, fields)
        else:
            show = _shower(stream, fields, is_full=is_full)
            made[stream.name] = _text_line(decode, show)
    return made


def _text_line(decode: Callable[[bytes], Any], show: Callable[[Any], str]) -> Line:
    return lambda arrival: show(decode(arrival.payload))


def _json_line(stream: Stream, decode: Callable[[bytes], Any], fields: tuple[str, ...]) -> Line:
    from rtkit.probe.text import field_reader, plain

    readers = {text: field_reader(text) for text in fields}
    ports = [str(end.path) for end in stream.ends]

    def line(arrival: Arrival) -> str:
        value = decode(arrival.payload)
        told = {text: plain(read(value)) for text, read in readers.items()} or plain(value)
        record = {
            "stream": stream.name,
            "ports": ports,
            "type": stream.data_type,
            "received": _records.time_text(arrival.time_ns),
            "value": told,
        }
        return _records.line("value", record)

    return line


def _shower(stream: Stream, fields: tuple[str, ...], *, is_full: bool) -> Callable[[Any], str]:
    from rtkit.cli._out import printable
    from rtkit.probe.formatters import formatter
    from rtkit.probe.text import field_reader, text_of

    if stream.formatter:
        form = formatter(stream.formatter)
        return lambda value: printable(form(value))
    readers = [field_reader(text) for text in fields] or [lambda value: value]
    return lambda value: "\t".join(
        printable(text_of(read(value), is_full=is_full)) for read in readers
    )
