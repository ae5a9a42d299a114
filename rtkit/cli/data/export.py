"""Exports values of a recording to other programs: lines of text, JSON Lines, CSV."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import TYPE_CHECKING, Any

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.progress import Show, counted, metered
from rtkit.errors import Malformed, Refused

if TYPE_CHECKING:
    from rtkit.recording.entries import RecordedStream, RecordedValue, RecordingSelection

_PIECE = 1000
Line = Callable[["RecordedValue", Any], Iterable[str]]


def export(app: App, name: str, form: str, part: RecordingSelection) -> None:
    """Write the values of a recording to stdout as text, JSON or CSV.

    Raises:
        Malformed: It is no recording.
        Refused: There is nothing in the part that is wanted.
    """
    from rtkit.recording.mcap_file import RecordingReader

    reader = RecordingReader(name)
    info = reader.info()
    channels = {channel.name: channel for channel in info.channels}
    warning = part.check(info.entries, info.first_ns, info.last_ns)
    if warning:
        app.fail(f"warning: {warning}")
        return
    with metered(app, "export", is_writing=True) as show:
        entries = _watched(reader.entries(), info.entries, show)
        lines = _lines(app, channels, part.of(entries), _FORMS[form](channels))
        first = next(lines, None)
        if first is None:
            raise Refused(f"no values in that part: {name}" if part.start else f"no values: {name}")
        if form == "csv":
            terminal.write(["received,stamp,stream,field,value"])
        terminal.write([first])
        while piece := list(islice(lines, _PIECE)):
            terminal.write(piece)
            sys.stdout.flush()


def _watched(entries: Iterator[RecordedValue], total: int, show: Show) -> Iterator[RecordedValue]:
    """Yield entries, and show how many of all have been read."""
    show_count = counted(show)
    for number, entry in enumerate(entries, 1):
        yield entry
        show_count(number, total)


def _lines(
    app: App, channels: dict[str, RecordedStream], entries: Iterator[RecordedValue], line: Line
) -> Iterator[str]:
    decoders = {name: _decoder(app, channel) for name, channel in channels.items()}
    for entry in entries:
        yield from line(entry, decoders[entry.channel](entry.payload))


def _decoder(app: App, channel: RecordedStream) -> Callable[[bytes], Any]:
    """Return what decodes values of a stream; those that are none of its type stay bytes."""
    from rtkit.component.values.codec import codec_for
    from rtkit.probe.known_types import type_or_bytes

    name = f"stream {channel.name}"
    cls = type_or_bytes(channel.data_type, name, app.fail, channel.definition)
    strict = codec_for(cls).decode
    is_reported = False

    def decode(payload: bytes) -> Any:
        nonlocal is_reported
        try:
            return strict(payload)
        except Malformed as error:
            if not is_reported:
                app.fail(f"warning: a value of {name} is no {channel.data_type}: {error}")
            is_reported = True
            return payload

    return decode


def _as_text(_channels: dict[str, RecordedStream]) -> Line:
    from rtkit.component.values.value_text import plain
    from rtkit.recording.text_log import line_of

    def line(entry: RecordedValue, value: Any) -> Iterable[str]:
        return [line_of(entry.channel, entry.time_ns, plain(value))]

    return line


def _as_json(channels: dict[str, RecordedStream]) -> Line:
    from rtkit.component.values.value_text import plain

    def line(entry: RecordedValue, value: Any) -> Iterable[str]:
        channel = channels[entry.channel]
        record = {
            "stream": channel.name,
            "ports": list(channel.sources),
            "type": channel.data_type,
            "received": json_records.time_text(entry.arrived_ns),
            "clock": {"host": channel.clock, **json_records.picked(channel, "offset_s bound_s")},
            "value": plain(value),
        }
        return [json_records.line("value", record)]

    return line


def _as_csv(_channels: dict[str, RecordedStream]) -> Line:
    from rtkit.component.values.fields import scalars

    def line(entry: RecordedValue, value: Any) -> Iterator[str]:
        received = json_records.time_text(entry.arrived_ns)
        stamp = json_records.time_text(entry.time_ns)
        for field, item in scalars(value):
            yield ",".join((received, stamp, *map(_cell, (entry.channel, field, item))))

    return line


def _cell(item: object) -> str:
    text = terminal.printable(item if isinstance(item, str) else str(item))
    return f'"{text.replace(chr(34), 2 * chr(34))}"' if any(c in text for c in ',"') else text


_FORMS: dict[str, Callable[[dict[str, RecordedStream]], Line]] = {
    "text": _as_text,
    "json": _as_json,
    "csv": _as_csv,
}
