"""Entries of a recording: streams, values and their extent; selects the wanted ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from rtkit.errors import Refused

NANOSECONDS = 1_000_000_000


class RecordedStream(NamedTuple):
    """One stream of a recording.

    Attributes:
        data_type: Name of the type of its values; empty where they may be of any.
        sources: Paths of the ports that it was recorded from.
        definition: IDL of the type, as a recording has it.
        clock: Host whose clock the time stamps of its values are of; empty if that is not known.
        offset_s: How far that was ahead of the one of the recorder [s].
        bound_s: By how much that may have been wrong [s].
    """

    name: str
    data_type: str
    sources: tuple[str, ...] = ()
    definition: str = ""
    clock: str = ""
    offset_s: float = 0.0
    bound_s: float = 0.0


class RecordedValue(NamedTuple):
    """One value of a recording.

    Attributes:
        time_ns: Its own time stamp, by the clock of the recorder, else when it arrived, Unix
            time [ns].
        arrived_ns: When it arrived, Unix time [ns].
        payload: The value in CDR.
        offset_ns: By how much its own time stamp is later than `time_ns`, of another clock [ns].
    """

    channel: str
    time_ns: int
    arrived_ns: int
    payload: bytes
    offset_ns: int = 0


class Span(NamedTuple):
    """Extent of one channel's entries in a recording.

    Attributes:
        first_ns: The earliest time of one, Unix time [ns]. Likewise `last_ns`.
        first_index: Place of the first among all entries, as they arrived. Likewise `last_index`.
    """

    first_ns: int
    last_ns: int
    first_index: int
    last_index: int

    def with_entry(self, time_ns: int, index: int) -> Span:
        """Return the span that has one more entry, the last so far."""
        first, last = min(self.first_ns, time_ns), max(self.last_ns, time_ns)
        return Span(first, last, self.first_index, index)


class Info(NamedTuple):
    """Facts about a recording that need no look at values.

    Attributes:
        began_ns: When the recording began, Unix time [ns].
        first_ns: Time of the first entry; None without any. Likewise `last_ns`.
        counts: Number of entries of each channel.
        is_whole: False where the recorder was killed before it could close the file.
        spans: Of each channel that has entries.
    """

    size: int
    began_ns: int
    first_ns: int | None
    last_ns: int | None
    channels: tuple[RecordedStream, ...]
    counts: Mapping[str, int]
    is_whole: bool
    spans: Mapping[str, Span]

    @property
    def entries(self) -> int:
        """Number of entries."""
        return sum(self.counts.values())


class RecordingSelection(NamedTuple):
    """Selection of entries by time or by index.

    Attributes:
        start: First one: a time [ns], or an index counted from 0; None for the beginning.
        end: Last one: a time; or an index, before which it ends when there is no start, and with
            which it ends when there is one, as in the tools of old; None for the end.
        is_by_index: Whether these are indices.
    """

    start: int | None = None
    end: int | None = None
    is_by_index: bool = False

    def check(self, count: int, first_ns: int | None, last_ns: int | None) -> str:
        """Return a warning if a recording of that extent ends before this begins to end.

        Raises:
            Refused: It ends before the first entry that is wanted.
        """
        if not count or first_ns is None or last_ns is None:
            return ""
        if self.is_by_index:
            what, first, last, extent = "index", 0, count - 1, f"0 to {count - 1}"
        else:
            what, first, last = "time", first_ns, last_ns
            extent = f"{first_ns / NANOSECONDS:.9f} to {last_ns / NANOSECONDS:.9f}"
        if self.start is not None and self.start > last:
            raise Refused(f"Start {what} out of bounds: the recording has {extent}")
        is_empty = self.is_by_index and self.start is None and self.end == 0
        if self.end is not None and (self.end < max(first, self.start or first) or is_empty):
            return f"End {what} out of bounds: the recording has {extent}"
        return ""

    def of(self, entries: Iterable[RecordedValue]) -> Iterator[RecordedValue]:
        """Yield the selected ones among entries in the order of their times."""
        last = self.end
        if last is not None and self.is_by_index and self.start is None:
            last -= 1
        for index, entry in enumerate(entries):
            place = index if self.is_by_index else entry.time_ns
            if last is not None and place > last:
                return
            if self.start is None or place >= self.start:
                yield entry
