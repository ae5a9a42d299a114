"""Records ports into a file."""

from __future__ import annotations

import errno
import re
import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from functools import partial
from typing import IO, TYPE_CHECKING

from rtkit.api.ports import reading, streams_at
from rtkit.cli.data.arguments import specified
from rtkit.cli.shared import stdout_reader
from rtkit.cli.shared.app import App
from rtkit.cli.shared.progress import Show, metered
from rtkit.cli.shared.signals import SteadyWork, waking_main
from rtkit.errors import Refused
from rtkit.link.atomic import STDOUT

if TYPE_CHECKING:
    from rtkit.probe.port_spec import Stream
    from rtkit.probe.stats import Stamp
    from rtkit.probe.tap import Arrival
    from rtkit.recording.entries import RecordedStream, RecordedValue, RecordingSelection
    from rtkit.recording.mcap_file import RecordingWriter
    from rtkit.rtc.profiles import PortRef

_NS = 1_000_000_000
_FROM_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""Errors of a write to a file; they do not name it."""
_FLUSH_S = 0.02
"""Time that a line of a text log waits for others: short, so that a kill loses few [s]."""


def record(
    app: App,
    name: str,
    form: str,
    ports: Sequence[str],
    part: RecordingSelection,
    duration_s: float | None,
    *,
    is_lossless: bool,
) -> None:
    """Record until a limit, an interruption, or until nothing more can come.

    Raises:
        RtkitError: A port is not there, or the file exists already or cannot be written.
    """
    from rtkit.rtc.enums import PortType

    app.bound(duration_s)
    specs = specified(app, ports, may_part=True)
    is_patient = any(spec.is_pattern for spec in specs)
    streams = streams_at(app.tree_at, specs, PortType.OUT, _name, is_patient=is_patient)
    if not streams:
        app.fail("warning: no such output port is there yet")
    types = {each.name: _type(app, each) for each in streams}
    warn = partial(_not_recorded, app)
    refused = warn if is_patient else None
    with (
        waking_main(),
        _ended_in_order(),
        opened(name, form) as file,
        _steady(name) as steady,
        _sink(form, file) as sink,
        reading(
            app.tree, "rtlog_recorder", streams, lossless=is_lossless, refused=refused
        ) as probe,
        (
            stdout_reader.while_read(probe.stop)
            if name == STDOUT
            else nullcontext(stdout_reader.StdoutReader())
        ) as reader,
    ):
        stamps = _Stamps(app, sink, streams, types)
        app.verbose(f"{probe.component.instance} is connected")
        limit = _Limit(part, duration_s)
        app.report(limit.announcement)
        with metered(app, "record", is_writing=name == STDOUT) as show, ExitStack() as stack:
            take = probe.take
            if is_patient:
                from rtkit.api.late_ports import LatePorts

                late = LatePorts(app, probe, specs, streams, _name, warn, stamps.add)
                take = stack.enter_context(late).take
            begin_s = time.process_time()
            _take(take, sink, limit, stamps.of, show, steady)
            spent_s = time.process_time() - begin_s
        reader.check()
        if probe.lost:
            app.report(f"{app.name}: {probe.lost} values were lost")
        each_us = spent_s * 1e6 / max(sink.count, 1)
        app.verbose(f"{sink.count} entries in {name}, {each_us:.0f} us of processor time each")
        if not is_patient:
            probe.check_connected()
    if not sink.count:
        raise Refused(f"nothing was recorded: no value came, {name} has no entries")


def _type(app: App, stream: Stream) -> type:
    """Return the class of a stream's values: bytes, with a warning, where its type is unknown."""
    from rtkit.probe.known_types import type_or_bytes
    from rtkit.rtc.data_types import scoped_name

    typed = stream.ends[0].path.typed
    if not scoped_name(stream.data_type):
        app.fail(f"warning: {typed} tells no data type; its values stay bytes")
    return type_or_bytes(stream.data_type, typed, app.fail, stream.definition)


def _not_recorded(app: App, why: str) -> None:
    app.fail(f"warning: {why}; it is not recorded")


class _Stamps:
    """Declares streams to a sink, and reads the time stamps of their values.

    Attributes:
        of: Reader of the time stamp of a value, by the name of its stream.
    """

    def __init__(
        self,
        app: App,
        sink: RecordingWriter | _TextSink,
        streams: Sequence[Stream],
        types: Mapping[str, type],
    ) -> None:
        self._app = app
        self._sink = sink
        self.of: dict[str, Stamp] = {}
        for stream in streams:
            self._declare(stream, types[stream.name])

    def add(self, stream: Stream) -> None:
        """Add a stream that has come."""
        self._declare(stream, _type(self._app, stream))

    def _declare(self, stream: Stream, cls: type) -> None:
        from rtkit.probe.stats import stamp_reader
        from rtkit.recording.entries import RecordedStream

        sources = tuple(str(end.path) for end in stream.ends)
        known = stream.data_type, sources, stream.definition
        channel = RecordedStream(stream.name, *known, *stream.clock)
        self._sink.add_channel(channel, cls)
        self.of[stream.name] = stamp_reader(cls)


def _name(_number: int, ref: PortRef) -> str:
    """Return the name of a stream that the user did not name, so that a port can be given it."""
    return re.sub(r"\W", "_", f"{ref.instance}_{ref.port}")


class _Terminated(BaseException):
    """Raised when SIGTERM arrives."""


@contextmanager
def _ended_in_order() -> Iterator[None]:
    """Unwind the body on SIGTERM, so that the file is finished, and then end the process."""

    def unwind(_number: int, _frame: object) -> None:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        raise _Terminated

    former = signal.signal(signal.SIGTERM, unwind)
    try:
        yield
    except _Terminated:
        signal.raise_signal(signal.SIGTERM)
    finally:
        signal.signal(signal.SIGTERM, former)


@contextmanager
def _steady(name: str) -> Iterator[AbstractContextManager[None]]:
    """Yield what is to hold signals back for the time of a write."""
    if name == STDOUT:
        yield nullcontext()  # a pipe may be full for ever, so there a signal ends a write
        return
    work = SteadyWork(signal.SIGINT, signal.SIGTERM)
    try:
        yield work
    finally:
        work.close()


@contextmanager
def opened(name: str, form: str) -> Iterator[IO[bytes]]:
    """Open a new file, or stdout for ``-``.

    Raises:
        Refused: There is one of that name, or a terminal is to show what is no text.
    """
    if name == STDOUT:
        if form != "text" and sys.stdout.isatty():
            raise Refused("a terminal cannot show MCAP: -f FILE, a pipe, or -l text")
        yield sys.stdout.buffer
        return
    try:
        file = open(name, "xb")  # noqa: SIM115 - closed below; only opening it may find another
    except FileExistsError:
        raise Refused(f"file exists already: {name}") from None
    try:
        with file:
            yield file
    except OSError as error:
        if error.filename is None and error.errno in _FROM_DISK:
            error.filename = name
        raise


@contextmanager
def _sink(form: str, file: IO[bytes]) -> Iterator[RecordingWriter | _TextSink]:
    if form == "text":
        yield _TextSink(file, 0.0 if file is sys.stdout.buffer else _FLUSH_S)
        return
    from rtkit.recording.mcap_file import RecordingWriter

    with RecordingWriter(file) as writer:
        yield writer


class _TextSink:
    """Writes a line for each value, at once or `delay_s` [s] after the line before."""

    def __init__(self, file: IO[bytes], delay_s: float) -> None:
        self._file = file
        self._delay_s = delay_s
        self._decode: dict[str, Callable[[bytes], object]] = {}
        self.count = 0
        self.flush_at: float | None = None
        self._flushed_at = 0.0

    def add_channel(self, channel: RecordedStream, cls: type) -> None:
        """Declare a stream, before its first value."""
        from rtkit.component.values.codec import codec_for

        self._decode[channel.name] = codec_for(cls).decode

    def write(self, entry: RecordedValue) -> None:
        from rtkit.component.values.value_text import plain
        from rtkit.recording.text_log import line_of

        value = plain(self._decode[entry.channel](entry.payload))
        self._file.write(f"{line_of(entry.channel, entry.time_ns, value)}\n".encode())
        self.count += 1
        if self.flush_at is None:
            self.flush_at = self._flushed_at + self._delay_s

    def flush(self) -> None:
        self._file.flush()
        self.flush_at, self._flushed_at = None, time.monotonic()


class _Limit:
    """End of a recording: after some time, at a time, after a number of entries, or never."""

    def __init__(self, part: RecordingSelection, duration_s: float | None) -> None:
        self.count = part.end if part.is_by_index and duration_s is None else None
        self.until: float | None = None
        self._begin = time.monotonic()
        if duration_s is not None:
            self.until = time.monotonic() + duration_s
            self.announcement = f"Recording for {duration_s}s."
        elif self.count is not None:
            self.announcement = f"Recording {self.count} entries."
        elif part.end is not None:
            self.until = time.monotonic() + (part.end - time.time_ns()) / _NS
            date = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(part.end / _NS))
            self.announcement = f"Recording until {date} ({part.end / _NS})."
        else:
            self.announcement = "Recording until interrupted."

    def progress(self, count: int, now: float) -> tuple[float, float | None, str]:
        """Return the part recorded and the whole, as entries or [s], and the number of entries."""
        text = f"{count} entries"
        if self.until is None:
            return count, self.count, text
        return now - self._begin, self.until - self._begin, text


def _take(
    take: Callable[[float | None], list[Arrival] | None],
    sink: RecordingWriter | _TextSink,
    limit: _Limit,
    stamps: Mapping[str, Stamp],
    show: Show,
    steady: AbstractContextManager[None],
) -> None:
    """Write arrivals until the limit, and flush the file's buffer when that is due."""
    from rtkit.recording.entries import RecordedValue

    while limit.count is None or sink.count < limit.count:
        piece = take(_sooner(limit.until, sink.flush_at))
        if piece is None:
            break
        if limit.count is not None:
            piece = piece[: limit.count - sink.count]
        with steady:
            for arrival in piece:
                stamp = stamps[arrival.stream](arrival.payload) or arrival.time_ns
                sink.write(RecordedValue(arrival.stream, stamp, arrival.time_ns, arrival.payload))
            now = time.monotonic()
            if sink.flush_at is not None and now >= sink.flush_at:
                sink.flush()
        show(*limit.progress(sink.count, now))
        if limit.until is not None and now >= limit.until:
            break


def _sooner(one: float | None, other: float | None) -> float | None:
    given = [each for each in (one, other) if each is not None]
    return min(given) if given else None
