"""Prints the values that ``rtprint`` receives: as lines, statistics or a chart."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.cli.shared import json_records, terminal

if TYPE_CHECKING:
    from rtkit.probe.port_spec import Stream
    from rtkit.probe.tap import Arrival

Line = Callable[["Arrival"], str]
_FRAME_S = 0.1
_SPAN_S = 30.0
_ROWS = 16
_COLOURS = ("green", "yellow", "cyan", "magenta", "red", "blue")


class PrintOptions(NamedTuple):
    """Options of the display of values; `fields` selects some of their fields."""

    fields: tuple[str, ...] = ()
    is_full: bool = False
    is_json: bool = False


class Sink:
    """Destination of values.

    Attributes:
        count: Number of values received.
    """

    count = 0

    def take(self, piece: Sequence[Arrival]) -> None:
        """Take values."""
        self.count += len(piece)

    def finish(self, lost: int) -> None:
        """Print the rest at the end; `lost` values were lost."""


class Printer(Sink):
    """Prints every value."""

    def __init__(
        self, streams: Sequence[Stream], types: Mapping[str, type], options: PrintOptions
    ) -> None:
        self._lines = lines_of(streams, types, options)

    def take(self, piece: Sequence[Arrival]) -> None:
        """See `Sink.take`."""
        super().take(piece)
        sys.stdout.write("".join(f"{self._lines[each.stream](each)}\n" for each in piece))
        sys.stdout.flush()


class Counter(Sink):
    """Counts values and prints statistics at the end."""

    def __init__(
        self, streams: Sequence[Stream], types: Mapping[str, type], options: PrintOptions
    ) -> None:
        from rtkit.probe.stats import Stats, stamp_reader

        self._streams = streams
        self._is_json = options.is_json
        self._stats = {
            each.name: Stats(
                stamp_reader(types[each.name]),
                _numbers(types[each.name], options.fields),
                round(each.clock.offset_s * 1e9),
            )
            for each in streams
        }

    def take(self, piece: Sequence[Arrival]) -> None:
        """See `Sink.take`."""
        super().take(piece)
        for arrival in piece:
            self._stats[arrival.stream].take(arrival)

    def finish(self, lost: int) -> None:
        """Print the statistics of each stream."""
        from rtkit.probe.stream_report import lines_of, record_of

        for stream in self._streams:
            stats = self._stats[stream.name].summary()
            if self._is_json:
                terminal.write([json_records.line("stream-stats", record_of(stream, stats, lost))])
            else:
                terminal.write(map(terminal.printable, lines_of(stream, stats)))


class Plotter(Sink):
    """Plots numbers over time: on a terminal live, else once at the end."""

    def __init__(
        self, streams: Sequence[Stream], types: Mapping[str, type], options: PrintOptions
    ) -> None:
        from rtkit.component.values.codec import codec_for
        from rtkit.probe.plot import Chart

        self._chart = Chart(_SPAN_S)
        self._decode = {name: codec_for(cls).decode for name, cls in types.items()}
        self._labels = labels_of(streams)
        self._readers = _readers(options.fields)
        self._is_live = terminal.is_terminal()
        self._shown = 0
        self._next = 0.0

    def take(self, piece: Sequence[Arrival]) -> None:
        """See `Sink.take`."""
        from rtkit.component.values.fields import numbers

        super().take(piece)
        for arrival in piece:
            value = self._decode[arrival.stream](arrival.payload)
            for field, read in self._readers.items():
                for name, number in numbers(read(value), field):
                    label = self._labels[arrival.stream]
                    curve = " ".join(filter(None, (label, name)))
                    self._chart.add(curve, arrival.time_ns * 1e-9, number)
        now = time.monotonic()
        if self._is_live and now >= self._next:
            self._next = now + _FRAME_S
            self._draw()

    def finish(self, lost: int) -> None:
        """Draw the chart as it is in the end."""
        if self.count:
            self._draw()

    def _draw(self) -> None:
        from shutil import get_terminal_size

        size = get_terminal_size()
        rows = min(_ROWS, size.lines - 1)
        lines = self._chart.lines(size.columns - 1, rows, _painted)
        back = f"\x1b[{self._shown}A" if self._is_live and self._shown else ""
        end = "\x1b[K\n" if self._is_live else "\n"
        sys.stdout.write(back + "".join(f"{line}{end}" for line in lines))
        sys.stdout.flush()
        self._shown = len(lines)


def _painted(text: str, curve: int) -> str:
    return terminal.styled(text, _COLOURS[curve % len(_COLOURS)])


def _readers(fields: tuple[str, ...]) -> dict[str, Callable[[Any], Any]]:
    from rtkit.component.values.value_text import field_reader

    return {text: field_reader(text) for text in fields} or {"": lambda value: value}


def _numbers(cls: type, fields: tuple[str, ...]) -> Mapping[str, Callable[[bytes], float]]:
    """Return a function that extracts the numbers in these fields from a value in CDR."""
    from rtkit.component.values.codec import codec_for
    from rtkit.component.values.value_text import field_reader
    from rtkit.errors import Malformed

    decode = codec_for(cls).decode

    def number(text: str) -> Callable[[bytes], float]:
        read = field_reader(text)

        def of(payload: bytes) -> float:
            found = read(decode(payload))
            if not isinstance(found, int | float):
                raise Malformed(f"{text} is no number: {type(found).__name__}")
            return float(found)

        return of

    return {text: number(text) for text in fields}


def labels_of(streams: Sequence[Stream]) -> dict[str, str]:
    """Return labels that tell the values of several streams apart; none for a single stream."""
    if len(streams) == 1:
        return {streams[0].name: ""}
    return {s.name: ",".join(end.path.typed.partition("#")[0] for end in s.ends) for s in streams}


def lines_of(
    streams: Sequence[Stream], types: Mapping[str, type], options: PrintOptions
) -> dict[str, Line]:
    """Return the function that formats an arrival as a line, by stream."""
    from rtkit.component.values.codec import codec_for

    made: dict[str, Line] = {}
    labels = labels_of(streams)
    for stream in streams:
        decode = codec_for(types[stream.name]).decode
        if options.is_json:
            made[stream.name] = json_line(stream, decode, options.fields)
        else:
            label = terminal.printable(labels[stream.name])
            made[stream.name] = _text_line(decode, _shower(stream, options), label)
    return made


def _text_line(decode: Callable[[bytes], Any], show: Callable[[Any], str], label: str) -> Line:
    head = f"{label}  " if label else ""
    return lambda arrival: head + show(decode(arrival.payload))


def json_line(stream: Stream, decode: Callable[[bytes], Any], fields: tuple[str, ...]) -> Line:
    """Return a function that formats an arrival as a record."""
    from rtkit.component.values.value_text import field_reader, plain

    readers = {text: field_reader(text) for text in fields}
    ports, clock = [str(end.path) for end in stream.ends], stream.clock._asdict()

    def line(arrival: Arrival) -> str:
        value = decode(arrival.payload)
        shown = {text: plain(read(value)) for text, read in readers.items()} or plain(value)
        record = {
            "stream": stream.name,
            "ports": ports,
            "type": stream.data_type,
            "received": json_records.time_text(arrival.time_ns),
            "clock": clock,
            "value": shown,
        }
        return json_records.line("value", record)

    return line


def _shower(stream: Stream, options: PrintOptions) -> Callable[[Any], str]:
    from rtkit.component.values.value_text import text_of
    from rtkit.probe.formatters import formatter

    if stream.formatter:
        form = formatter(stream.formatter)
        return lambda value: terminal.printable(form(value))
    readers = list(_readers(options.fields).values())
    return lambda value: "\t".join(
        terminal.printable(text_of(read(value), is_full=options.is_full)) for read in readers
    )
