"""Writes MCAP files without a copy of large values between their memory and the file.

The writer of the mcap package copies each value three times before it writes it. Here the records
that there are many of are packed by their format (https://mcap.dev/spec); all others are those of
the package.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from typing import IO, TYPE_CHECKING, TypeAlias

try:
    from isal.isal_zlib import crc32
except ImportError:  # there is no wheel for this machine: eight times as long, the same numbers
    from zlib import crc32

if TYPE_CHECKING:
    from mcap.records import McapRecord

Part: TypeAlias = bytes | bytearray | memoryview

_MAGIC = b"\x89MCAP0\r\n"
_FOOTER, _MESSAGE, _CHUNK, _MESSAGE_INDEX = 2, 5, 6, 7
_RECORD = struct.Struct("<BQ")
_VALUE = struct.Struct("<BQHIQQ")
_EXTENT = struct.Struct("<QQQI")
_SUMMARY = struct.Struct("<BQQQ")
_CHUNK_BYTES = 512 << 10
_LARGE = 4 << 10
"""Size from which a value is not copied [bytes]."""


class McapWriter:
    """Writes one file, from its beginning.

    Values are gathered in chunks; each is written when it is large enough, or by `flush`.

    Args:
        file: Where it is written, buffered; a pipe will do.
        profile: Rules that the file keeps to.
        library: Name of the program that writes it.
    """

    def __init__(self, file: IO[bytes], profile: str, library: str) -> None:
        from mcap.opcode import Opcode
        from mcap.records import Header, Statistics

        self._file = file
        self._at = 0
        self._chunk = _Chunk()
        self._is_settled = True
        self._plain: set[int] = set()
        self._statistics = Statistics(0, 0, {}, 0, 0, 0, 0, 0, 0)
        kinds = Opcode.SCHEMA, Opcode.CHANNEL, Opcode.CHUNK_INDEX, Opcode.METADATA_INDEX
        self._groups = {int(kind): bytearray() for kind in kinds}
        self._write([_MAGIC, _packed(Header(profile, library))])

    def add_metadata(self, name: str, members: Mapping[str, str]) -> None:
        """Write what is known of the file."""
        from mcap.records import Metadata, MetadataIndex

        record = _packed(Metadata(name, dict(members)))
        self._keep(MetadataIndex(self._at, len(record), name))
        self._statistics.metadata_count += 1
        self._write([record])

    def add_schema(self, name: str, encoding: str, text: bytes) -> int:
        """Write the definition of a type, and return its number."""
        from mcap.records import Schema

        self._statistics.schema_count += 1
        number = self._statistics.schema_count
        self._write([self._keep(Schema(number, text, encoding, name))])
        return number

    def add_channel(
        self, topic: str, schema: int, members: Mapping[str, str], *, is_compressed: bool
    ) -> int:
        """Write that there is a channel of values in CDR, and return its number.

        A chunk is compressed when all its values are of channels that are.
        """
        from mcap.records import Channel

        self._statistics.channel_count += 1
        number = self._statistics.channel_count
        if not is_compressed:
            self._plain.add(number)
        self._write([self._keep(Channel(number, topic, "cdr", dict(members), schema))])
        return number

    def add_value(
        self, channel: int, sequence: int, log_ns: int, publish_ns: int, value: Part
    ) -> None:
        """Add a value, which is not to change until its chunk is written."""
        self._chunk.add(channel, sequence, log_ns, publish_ns, value)
        if self._chunk.size > _CHUNK_BYTES:
            self._end_chunk()

    def flush(self) -> None:
        """Write the present chunk, and what the file holds back."""
        self._end_chunk()
        self._file.flush()

    def finish(self) -> None:
        """Write what is left, and the summary.

        After a write that failed, or was interrupted, nothing is written: what stands before it can
        be read, as in a file of a writer that was killed.
        """
        from mcap.records import DataEnd, Footer, SummaryOffset

        if not self._is_settled:
            return
        self._end_chunk()
        self._write([_packed(DataEnd(0))])
        self._keep(self._statistics)
        begin, summary, offsets = self._at, bytearray(), bytearray()
        for kind, records in self._groups.items():
            if records:
                offsets += _packed(SummaryOffset(kind, begin + len(summary), len(records)))
                summary += records
        at = begin + len(summary)
        summary += offsets
        crc = crc32(_SUMMARY.pack(_FOOTER, 20, begin, at), crc32(summary))
        self._write([summary, _packed(Footer(begin, at, crc)), _MAGIC])

    def _keep(self, record: McapRecord) -> bytes:
        """Return a record that the summary has, too."""
        octets = _packed(record)
        self._groups.setdefault(octets[0], bytearray()).extend(octets)
        return octets

    def _end_chunk(self) -> None:
        from mcap.records import ChunkIndex

        chunk = self._chunk
        if not chunk.size:
            return
        self._is_settled = False
        self._chunk = _Chunk()
        compression = "" if self._plain & chunk.places.keys() else "lz4"
        stored = _compressed(chunk) if compression else chunk.parts
        begin, size = self._at, sum(map(len, stored))
        extent = _EXTENT.pack(chunk.first_ns, chunk.last_ns, chunk.size, _crc(chunk.parts))
        named = struct.pack("<I", len(compression)) + compression.encode()
        body = extent + named + struct.pack("<Q", size)
        self._write([_RECORD.pack(_CHUNK, len(body) + size) + body, *stored])
        end, indexes, offsets = self._at, bytearray(), {}
        for channel, places in chunk.places.items():
            offsets[channel] = end + len(indexes)
            indexes += _message_index(channel, places)
        self._write([indexes])
        times = {"message_start_time": chunk.first_ns, "message_end_time": chunk.last_ns}
        index = ChunkIndex(
            chunk_length=end - begin,
            chunk_start_offset=begin,
            compression=compression,
            compressed_size=size,
            message_index_length=len(indexes),
            message_index_offsets=offsets,
            uncompressed_size=chunk.size,
            **times,
        )
        self._keep(index)
        self._count(chunk)
        self._is_settled = True

    def _count(self, chunk: _Chunk) -> None:
        known = self._statistics
        if not known.message_count:
            known.message_start_time = chunk.first_ns
        known.message_start_time = min(known.message_start_time, chunk.first_ns)
        known.message_end_time = max(known.message_end_time, chunk.last_ns)
        known.chunk_count += 1
        for channel, places in chunk.places.items():
            count = len(places) // 2
            known.message_count += count
            before = known.channel_message_counts.get(channel, 0)
            known.channel_message_counts[channel] = before + count

    def _write(self, parts: list[Part]) -> None:
        was_settled, self._is_settled = self._is_settled, False
        self._file.writelines(parts)  # one call, so that no signal handler raises in between
        self._at += sum(map(len, parts))
        self._is_settled = was_settled


class _Chunk:
    """Values that are written together.

    Attributes:
        parts: Their records, one after the other; large values stand where they came.
        places: Of each channel the time [ns] and the offset of each of its values.
        size: Of all records [bytes].
    """

    def __init__(self) -> None:
        self._small = bytearray()
        self.parts: list[Part] = [self._small]
        self.places: dict[int, list[int]] = {}
        self.first_ns = self.last_ns = self.size = 0

    def add(self, channel: int, sequence: int, log_ns: int, publish_ns: int, value: Part) -> None:
        """Add the record of a value."""
        self.first_ns = min(self.first_ns, log_ns) if self.size else log_ns
        self.last_ns = max(self.last_ns, log_ns)
        self.places.setdefault(channel, []).extend((log_ns, self.size))
        size = len(value)
        small = self._small
        length = _VALUE.size - _RECORD.size + size
        small += _VALUE.pack(_MESSAGE, length, channel, sequence, log_ns, publish_ns)
        if size < _LARGE:
            small += value
        else:
            self._small = bytearray()
            self.parts += (value, self._small)
        self.size += _VALUE.size + size


def _message_index(channel: int, places: list[int]) -> bytes:
    size = 8 * len(places)
    form = f"<BQHI{len(places)}Q"
    return struct.pack(form, _MESSAGE_INDEX, 6 + size, channel, size, *places)


def _packed(record: McapRecord) -> bytes:
    from mcap.data_stream import RecordBuilder

    builder = RecordBuilder()
    record.write(builder)
    octets: bytes = builder.end()  # type: ignore[no-untyped-call]
    return octets


def _compressed(chunk: _Chunk) -> list[Part]:
    import lz4.frame  # type: ignore[import-untyped]

    compressor = lz4.frame.LZ4FrameCompressor()
    head = compressor.begin(source_size=chunk.size)
    return [head, *map(compressor.compress, chunk.parts), compressor.flush()]


def _crc(parts: Iterable[Part]) -> int:
    crc = 0
    for part in parts:
        crc = crc32(part, crc)
    return crc
