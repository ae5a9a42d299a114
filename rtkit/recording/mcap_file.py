"""Reads and writes recordings as MCAP files: self-describing, indexed, readable after a crash.

Values stand in chunks. A chunk is closed after half a second at the latest, and each closed chunk
can be read even if the file was never finished.
"""

from __future__ import annotations

import os
import struct
import time
from collections import Counter
from collections.abc import Iterator
from types import TracebackType
from typing import IO, Any, Self

from rtkit.component.values.definition import ENCODING, has_octets, idl_of, name_of
from rtkit.errors import Malformed
from rtkit.recording.entries import NANOSECONDS, Info, RecordedStream, RecordedValue, Span
from rtkit.rtc.data_types import scoped_name

CHUNK_S = 0.5
"""Longest time that a chunk stays open [s]."""

_PROFILE = "rtkit"
_META = "rtkit.recording"
_MAX_RECORD = 1 << 30
_LONGEST_S = 1e12
"""Offset of a clock above which a file tells no sense [s]."""


class RecordingWriter:
    """Writes a recording; use as a context manager, which finishes the file.

    Attributes:
        count: Number of values written.
    """

    def __init__(self, file: IO[bytes]) -> None:
        from rtkit.recording.mcap_writer import McapWriter

        self._mcap = McapWriter(file, _PROFILE, "rtkit")
        self._mcap.add_metadata(_META, {"began_ns": str(time.time_ns())})
        self._numbers: dict[str, int] = {}
        self._sequence: dict[str, int] = {}
        self._close_at: float | None = None
        self.count = 0
        file.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._mcap.finish()

    @property
    def flush_at(self) -> float | None:
        """Latest time at which `flush` is due, monotonic [s]; None while nothing waits."""
        return self._close_at

    def add_channel(self, channel: RecordedStream, cls: type) -> None:
        """Declare a stream, once, before its first value.

        Of one that is recorded as bytes the schema is what is known of its type: the definition
        that came with it, or the name alone. Values with octets, which images consist of, hardly
        become shorter, and to compress them would take most of the time.
        """
        text = channel.definition if cls is bytes else _text_of(cls)
        name = scoped_name(channel.data_type) if cls is bytes else name_of(cls)
        encoding = ENCODING if text else ""
        number = self._mcap.add_schema(name, encoding, text.encode()) if name else 0
        sources = "\n".join(channel.sources)
        self._numbers[channel.name] = self._mcap.add_channel(
            channel.name,
            number,
            {"data_type": channel.data_type, "sources": sources, **_of_clock(channel)},
            is_compressed=not has_octets(cls),
        )

    def write(self, entry: RecordedValue) -> None:
        """Add a value to the present chunk; it is not to change until that is closed."""
        sequence = self._sequence[entry.channel] = self._sequence.get(entry.channel, -1) + 1
        number = self._numbers[entry.channel]
        self.count += 1
        # Viewers go by the first time, which is that of the arrival.
        stamp_ns = entry.time_ns + entry.offset_ns
        self._mcap.add_value(number, sequence, entry.arrived_ns, stamp_ns, entry.payload)
        now = time.monotonic()
        if self._close_at is None:
            self._close_at = now + CHUNK_S
        elif now >= self._close_at:
            self.flush()

    def flush(self) -> None:
        """Close the present chunk, so that its values can be read."""
        self._mcap.flush()
        self._close_at = None


def _of_clock(channel: RecordedStream) -> dict[str, str]:
    """Return what a recording says of the clock of the time stamps; nothing if it is not known."""
    if not channel.clock:
        return {}
    numbers = {"clock_offset_s": repr(channel.offset_s), "clock_bound_s": repr(channel.bound_s)}
    return {"clock": channel.clock, **numbers}


def _number(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        return 0.0
    return number if abs(number) < _LONGEST_S else 0.0


def _text_of(cls: type) -> str:
    """Return the definition of a type; "" for one that IDL has no words for."""
    try:
        return idl_of(cls)
    except Malformed:
        return ""


class RecordingReader:
    """Reads a recording, also one that was never finished."""

    def __init__(self, path: str) -> None:
        self._path = path

    def info(self) -> Info:
        """Read the whole file and return the facts about it.

        Raises:
            Malformed: It is no recording.
            OSError: It cannot be read.
        """
        counts: Counter[str] = Counter()
        spans: dict[str, Span] = {}
        walk = _Walk(self._path)
        for index, entry in enumerate(walk.entries()):
            counts[entry.channel] += 1
            known = spans.get(entry.channel, Span(entry.time_ns, entry.time_ns, index, index))
            spans[entry.channel] = known.with_entry(entry.time_ns, index)
        first = min((span.first_ns for span in spans.values()), default=None)
        last = max((span.last_ns for span in spans.values()), default=None)
        return Info(
            os.path.getsize(self._path),
            walk.began_ns or first or 0,
            first,
            last,
            tuple(walk.channels.values()),
            {name: counts[name] for name in walk.channels},
            walk.is_whole,
            spans,
        )

    def entries(self) -> Iterator[RecordedValue]:
        """Yield all entries in the order in which they arrived.

        Raises:
            Malformed: It is no recording.
            OSError: It cannot be read.
        """
        return _Walk(self._path).entries()


class _Walk:
    """One walk through a file from its beginning.

    Attributes:
        channels: The streams that were declared so far.
        began_ns: When the recording began, Unix time [ns]; 0 if that was not met.
        is_whole: Whether the file was finished, once the walk is over.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self.channels: dict[str, RecordedStream] = {}
        self.began_ns = 0
        self._names: dict[int, str] = {}
        self._schemas: dict[int, tuple[str, str]] = {}
        self.is_whole = False

    def entries(self) -> Iterator[RecordedValue]:
        from mcap import records
        from mcap.exceptions import EndOfFile, McapError
        from mcap.stream_reader import CRCValidationError, StreamReader

        with open(self._path, "rb") as file:
            reader = StreamReader(file, validate_crcs=True, record_size_limit=_MAX_RECORD)
            is_begun = False
            try:
                for record in reader.records:
                    is_begun = True
                    if isinstance(record, records.Message):
                        yield self._entry(record)
                    elif isinstance(record, records.DataEnd):
                        self.is_whole = True  # a summary follows: streams without values, too
                    else:
                        self._take(record)
            except (EndOfFile, CRCValidationError, struct.error) as error:
                if not is_begun:
                    raise self._broken(error, is_begun) from error
            except (McapError, ValueError, RuntimeError, KeyError, MemoryError) as error:
                if not self.is_whole:
                    raise self._broken(error, is_begun) from error

    def _broken(self, error: Exception, is_begun: bool) -> Malformed:
        if not is_begun:
            what = "not MCAP" if os.path.getsize(self._path) else "it is empty"
            return Malformed(f"no recording: {self._path}: {what}")
        return Malformed(f"damaged recording: {self._path}: {' '.join(str(error).split())}")

    def _take(self, record: Any) -> None:
        from mcap import records

        if isinstance(record, records.Schema):
            is_idl = record.encoding == ENCODING
            text = record.data.decode("utf-8", "replace") if is_idl else ""
            self._schemas[record.id] = record.name, text
        elif isinstance(record, records.Channel):
            self._names[record.id] = record.topic
            schema, definition = self._schemas.get(record.schema_id, ("", ""))
            named = record.metadata.get("data_type", "") or schema
            sources = tuple(filter(None, record.metadata.get("sources", "").split("\n")))
            about = record.metadata
            found = RecordedStream(
                record.topic,
                scoped_name(named),
                sources,
                definition,
                about.get("clock", ""),
                _number(about.get("clock_offset_s", "")),
                _number(about.get("clock_bound_s", "")),
            )
            self.channels[record.topic] = found
        elif isinstance(record, records.Metadata) and record.name == _META:
            text = record.metadata.get("began_ns", "")
            if text.isascii() and text.isdigit():
                self.began_ns = int(text)

    def _entry(self, message: Any) -> RecordedValue:
        name = self._names[message.channel_id]
        channel = self.channels.get(name)
        # Without a stamp of its own a value bears the time of its arrival, which needs no offset.
        is_stamped = message.publish_time != message.log_time
        offset_ns = round(channel.offset_s * NANOSECONDS) if channel and is_stamped else 0
        time_ns = message.publish_time - offset_ns
        return RecordedValue(name, time_ns, message.log_time, message.data, offset_ns)
