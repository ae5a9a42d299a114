"""Plays recordings into ports and reports on them."""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api.ports import streams_of, writing
from rtkit.cli.data.arguments import specified
from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.progress import metered
from rtkit.errors import Refused

if TYPE_CHECKING:
    from rtkit.api.ports import Probe
    from rtkit.probe.port_spec import Stream
    from rtkit.recording.entries import Info, RecordedStream, RecordedValue, RecordingSelection

_NS = 1_000_000_000
_UNNAMED = "\0"
"""Prefix of the names of streams that the user did not name."""


class PlaybackPace(NamedTuple):
    """Speed of a playback.

    Attributes:
        factor: Speed relative to the recording; untimed: entries per cycle.
        cycles_hz: Cycles a second, untimed.
        is_absolute: Whether time stamps stay as they were recorded.
        duration_s: Duration of the playback [s]; None for all of the recording.
    """

    factor: float
    is_untimed: bool
    cycles_hz: float
    is_absolute: bool
    duration_s: float | None

    def due_s(self, index: int, entry: RecordedValue, first: RecordedValue) -> float:
        """Return the time from the beginning until an entry is played [s]."""
        if self.is_untimed:
            return index // max(1, int(self.factor)) / self.cycles_hz
        return max(0.0, (entry.time_ns - first.time_ns) / _NS / self.factor)


def describe(app: App, name: str, *, is_json: bool) -> None:
    """Print the content of a recording."""
    from rtkit.recording.mcap_file import RecordingReader

    info = RecordingReader(name).info()
    if is_json:
        terminal.write([json_records.line("recording", _record(name, info))])
    else:
        terminal.write(map(terminal.printable, _lines(name, info)))


def _record(name: str, info: Info) -> dict[str, object]:
    return {
        "name": name,
        "size_bytes": info.size,
        "is_whole": info.is_whole,
        "began": _iso(info.began_ns),
        "first": _iso(info.first_ns),
        "last": _iso(info.last_ns),
        "entries": info.entries,
        "channels": [_channel_record(each, info) for each in info.channels],
    }


def _channel_record(channel: RecordedStream, info: Info) -> dict[str, object]:
    span = info.spans.get(channel.name)
    fields = {name: value for name, value in channel._asdict().items() if name != "definition"}
    return {
        **fields,
        "entries": info.counts[channel.name],
        "first": _iso(span and span.first_ns),
        "last": _iso(span and span.last_ns),
        "first_index": span and span.first_index,
        "last_index": span and span.last_index,
    }


def _iso(time_ns: int | None) -> str | None:
    return None if time_ns is None else json_records.time_text(time_ns)


def _lines(name: str, info: Info) -> Iterator[str]:
    yield f"Name: {name}"
    yield f"Size: {_size(info.size)}"
    yield f"Start time: {_date(info.began_ns)}"
    if info.first_ns is not None and info.last_ns is not None:
        yield f"First entry time: {_date(info.first_ns)}"
        yield f"End time: {_date(info.last_ns)}"
    yield f"Number of entries: {info.entries}"
    if not info.is_whole:
        why = "the recorder was killed, or the disk was full"
        yield f"Not finished: {why}; everything above can be read"
    for number, channel in enumerate(info.channels, start=1):
        yield f"Channel {number}"
        yield f"  Name: {channel.name}"
        yield f"  Data type: {channel.data_type or 'any'}"
        yield f"  Entries: {info.counts[channel.name]}"
        span = info.spans.get(channel.name)
        if span is not None:
            yield f"  Indices: {span.first_index} to {span.last_index}"
            yield f"  Times: {_date(span.first_ns)} to {_date(span.last_ns)}"
        if channel.clock:
            ahead = f", {channel.offset_s:+.4f} s (± {channel.bound_s:.4f} s), taken off the times"
            yield f"  Clock of time stamps: {channel.clock}{ahead * bool(channel.offset_s)}"
        yield "  Sources:"
        yield from (f"    {source}" for source in channel.sources)


def _size(count: int) -> str:
    """Return a number of bytes in the words of rtshell."""
    for exponent, unit in ((3, "GiB"), (2, "MiB"), (1, "KiB")):
        if count >= 1024**exponent:
            return f"{count / 1024**exponent:.2f} {unit} ({count} bytes)"
    return f"{count} bytes"


def _date(time_ns: int) -> str:
    text = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(time_ns // _NS))
    return f"{text} ({time_ns // _NS}.{time_ns % _NS:09})"


def play(
    app: App,
    name: str,
    form: str,
    ports: Sequence[str],
    part: RecordingSelection,
    pace: PlaybackPace,
    *,
    is_lossless: bool,
) -> None:
    """Play a recording into in ports.

    Raises:
        RtkitError: A port, or the part that is wanted, is not there, or the types differ.
    """
    from rtkit.rtc.enums import PortType

    app.bound(pace.duration_s)
    specs = specified(app, ports)
    streams = streams_of(app.tree, specs, PortType.IN, lambda number, _: f"{_UNNAMED}{number}")
    source = _TextSource(name) if form == "text" else _McapSource(name)
    chosen = _matched(app, streams, source.channels)
    warning = part.check(*source.extent)
    if warning:
        app.fail(f"warning: {warning}")
        return
    renamed = tuple(s._replace(name=f"output{i}") for i, s in enumerate(streams))
    outs: dict[str, list[str]] = {}
    for stream, own in zip(streams, renamed, strict=True):
        if stream.name in chosen:
            outs.setdefault(chosen[stream.name], []).append(own.name)
    types = {own.name: own for own in renamed}
    entries = source.entries(outs, types)
    passed = dict.fromkeys(types, bytes)
    with writing(app.tree, "rtlog_player", renamed, passed, lossless=is_lossless) as probe:
        app.verbose(f"{probe.component.instance} is connected")
        app.report(_announcement(part, pace))
        with metered(app, "play") as show:
            is_whole = part.start is None and part.end is None
            total = sum(source.counts[name] for name in outs) if is_whole else None
            is_over = _write(
                probe, part.of(entries), outs, pace, part, lambda n: show(n, total, f"{n} values")
            )
        probe.flush()
    if is_over:
        app.report("End of log reached.")


def _announcement(part: RecordingSelection, pace: PlaybackPace) -> str:
    """Return the announcement of a playback, in the words of rtshell."""
    if pace.duration_s is not None:
        return f"Playing for {pace.duration_s}s."
    unit = "entry " if part.is_by_index else ""
    start = "" if part.start is None else f"{unit}{_place(part, part.start)}"
    end = "" if part.end is None else f"{unit}{_place(part, part.end)}"
    if start and end:
        return f"Playing from {start} {'to' if part.is_by_index else 'until'} {end}."
    if start:
        return f"Playing from {start}."
    if end:
        return f"Playing {part.end} entries." if part.is_by_index else f"Playing until {end}."
    return "Playing."


def _place(part: RecordingSelection, place: int) -> str:
    return str(place) if part.is_by_index else _date(place)


def _matched(
    app: App, streams: Sequence[Stream], channels: Sequence[RecordedStream]
) -> dict[str, str]:
    """Return the channel that each stream plays, by stream name.

    Raises:
        Refused: A port has another data type than its channel, or there is nothing to play.
    """
    from rtkit.component.values.defined import is_same_definition
    from rtkit.rtc.data_types import is_same_type

    named = {channel.name: channel for channel in channels}
    left = list(channels)
    chosen: dict[str, str] = {}
    for stream in streams:
        typed = stream.ends[0].path.typed
        if stream.name.startswith(_UNNAMED):
            fitting = (c for c in left if is_same_type(c.data_type, stream.data_type))
            channel = next(fitting, None)
            if channel is None:
                raise Refused(
                    f"{typed}: no stream of {stream.data_type} is left: {_contents(channels)}"
                )
            left.remove(channel)
        else:
            channel = named.get(stream.name)
            if channel is None:
                app.report(f"{app.name}: warning: {typed}: no such stream, {_contents(channels)}")
                continue
            if not is_same_type(channel.data_type, stream.data_type):
                raise Refused(
                    f"{typed} has {stream.data_type}, stream {channel.name} {channel.data_type}"
                )
        if not is_same_definition(stream.data_type, channel.definition, stream.definition):
            raise Refused(f"{typed}: {stream.data_type} is defined otherwise than in the recording")
        chosen[stream.name] = channel.name
    if not chosen:
        raise Refused("there is nothing to play")
    return chosen


def _contents(channels: Sequence[RecordedStream]) -> str:
    names = (f"{channel.name} ({channel.data_type or 'any'})" for channel in channels)
    return f"the recording has {', '.join(names) or 'none'}"


def _write(
    probe: Probe,
    entries: Iterator[RecordedValue],
    outs: Mapping[str, Sequence[str]],
    pace: PlaybackPace,
    part: RecordingSelection,
    count: Callable[[int], None],
) -> bool:
    """Write entries when they are due; return whether the recording came to its end.

    Raises:
        Refused: There was nothing in the part that is wanted, or nobody is left to write to.
    """
    from rtkit.recording.time_stamps import shifted

    first: RecordedValue | None = None
    begin = time.monotonic()
    until = None if pace.duration_s is None else begin + pace.duration_s
    for index, entry in enumerate(each for each in entries if each.channel in outs):
        first = first or entry
        due = begin + pace.due_s(index, entry, first)
        if until is not None and due >= until:
            probe.wait(until)
            return False
        probe.wait(due)
        payload = (
            entry.payload
            if pace.is_absolute
            else shifted(entry.payload, entry.time_ns + entry.offset_ns)
        )
        for port in outs[entry.channel]:
            probe.write(port, payload)
        count(index + 1)
    if first is None:
        raise Refused("nothing was recorded in that part" if part.start else "nothing to play")
    return part.end is None


class _McapSource:
    """An MCAP file."""

    def __init__(self, name: str) -> None:
        from rtkit.recording.mcap_file import RecordingReader

        self._reader = RecordingReader(name)
        info = self._reader.info()
        self.channels = info.channels
        self.counts: Mapping[str, int] = info.counts
        self.extent = (info.entries, info.first_ns, info.last_ns)

    def entries(
        self, outs: Mapping[str, Sequence[str]], types: Mapping[str, Stream]
    ) -> Iterator[RecordedValue]:
        """Yield all entries."""
        return self._reader.entries()


class _TextSource:
    """A text log; its values are read as those of the ports that they are played into."""

    def __init__(self, name: str) -> None:
        from rtkit.recording.entries import RecordedStream
        from rtkit.recording.text_log import read_file

        self._lines = list(read_file(name))
        streams = dict.fromkeys(line.stream for line in self._lines)
        self.channels = tuple(RecordedStream(stream, "") for stream in streams)
        self.counts: Mapping[str, int] = Counter(line.stream for line in self._lines)
        times = [line.time_ns for line in self._lines]
        self.extent = (len(times), min(times, default=None), max(times, default=None))

    def entries(
        self, outs: Mapping[str, Sequence[str]], types: Mapping[str, Stream]
    ) -> Iterator[RecordedValue]:
        """Yield all entries of the streams that are played.

        Raises:
            Malformed: A value is none of the port's type.
        """
        from rtkit.component.types import Time
        from rtkit.component.values.codec import codec_for
        from rtkit.component.values.literal import Literal
        from rtkit.probe.known_types import data_type
        from rtkit.recording.entries import RecordedValue

        played = {name: types[ports[0]] for name, ports in outs.items()}
        classes = {
            name: data_type(each.data_type, each.ends[0].path.typed, each.definition)
            for name, each in played.items()
        }
        for line in self._lines:
            cls = classes.get(line.stream)
            if cls is None:
                continue
            stamp = Time(*divmod(line.time_ns, _NS))
            value = Literal(cls, json.dumps(line.value)).at(stamp)
            payload = codec_for(cls).encode(value)
            yield RecordedValue(line.stream, line.time_ns, line.time_ns, payload)
