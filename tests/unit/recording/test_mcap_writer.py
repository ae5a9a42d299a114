"""Files that are written without a copy of what is large."""

from __future__ import annotations

import errno
import io
import os
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap.records import Chunk, MessageIndex
from mcap.stream_reader import StreamReader

from rtkit.recording.mcap_writer import McapWriter

LARGE = [bytes([number]) * 300_000 for number in range(5)]
TEXT = b"the same again and again " * 40


def written(file: Any, *, is_finished: bool = True) -> list[tuple[str, int, bytes]]:
    """Write a text and an image in turns, then texts alone; return channel, time and value."""
    writer = McapWriter(file, "test", "rtkit")
    schema = writer.add_schema("RTC::TimedOctetSeq", "omgidl", b"struct T {};")
    image = writer.add_channel("image", schema, {"data_type": "x"}, is_compressed=False)
    text = writer.add_channel("text", 0, {}, is_compressed=True)
    values = []
    for number, large in enumerate(LARGE):
        values += [("text", 2 * number, TEXT), ("image", 2 * number + 1, large)]
    values += [("text", 100 + number, TEXT) for number in range(3)]
    for channel, time_ns, value in values:
        if time_ns == 100:
            writer.flush()
        writer.add_value(
            image if channel == "image" else text, 0, time_ns, time_ns, memoryview(value)
        )
    if is_finished:
        writer.finish()
    return values


def read(data: bytes, **selected: Any) -> list[tuple[str, int, bytes]]:
    found = make_reader(io.BytesIO(data), validate_crcs=True).iter_messages(**selected)
    return [(channel.topic, message.log_time, message.data) for _, channel, message in found]


def chunks_of(data: bytes) -> list[Chunk]:
    records = StreamReader(io.BytesIO(data), emit_chunks=True, validate_crcs=True).records
    return [record for record in records if isinstance(record, Chunk)]


def test_a_reader_of_others_finds_each_value_by_the_indexes() -> None:
    file = io.BytesIO()
    values = written(file)
    data = file.getvalue()
    assert read(data) == values
    assert read(data, topics=["image"], starting_at=3, ending_before=8) == [
        each for each in values if each[0] == "image" and 3 <= each[1] < 8
    ]
    summary = make_reader(io.BytesIO(data), validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    told = summary.statistics
    assert (told.message_count, told.chunk_count) == (13, len(chunks_of(data)))
    assert (told.message_start_time, told.message_end_time) == (0, 102)
    assert sorted(told.channel_message_counts.values()) == [5, 8]
    assert [each.name for each in summary.schemas.values()] == ["RTC::TimedOctetSeq"]
    for index, chunk in zip(summary.chunk_indexes, chunks_of(data), strict=True):
        assert data[index.chunk_start_offset] == 6
        assert index.uncompressed_size == chunk.uncompressed_size
        for offset in index.message_index_offsets.values():
            assert data[offset] == 7


def test_the_index_of_a_chunk_leads_to_its_values() -> None:
    file = io.BytesIO()
    written(file)
    records = StreamReader(io.BytesIO(file.getvalue()), emit_chunks=True).records
    indexes = [each for each in records if isinstance(each, MessageIndex)]
    assert sum(len(each.records) for each in indexes) == 13


def test_only_chunks_without_images_are_compressed() -> None:
    file = io.BytesIO()
    written(file)
    kinds = [chunk.compression for chunk in chunks_of(file.getvalue())]
    assert set(kinds[:-1]) == {""}
    assert kinds[-1] == "lz4"
    assert len(chunks_of(file.getvalue())[-1].data) < len(TEXT)
    assert all(chunk.uncompressed_crc for chunk in chunks_of(file.getvalue()))


def test_a_damaged_image_is_noticed() -> None:
    from mcap.stream_reader import CRCValidationError

    file = io.BytesIO()
    written(file)
    data = bytearray(file.getvalue())
    data[data.index(LARGE[3]) + 1000] ^= 1
    with pytest.raises(CRCValidationError):
        read(bytes(data))


class _Parts(io.BytesIO):
    """Keeps what it was given."""

    def __init__(self) -> None:
        super().__init__()
        self.given: list[Any] = []

    def writelines(self, lines: Any) -> None:
        self.given += lines
        super().writelines(lines)


def test_a_large_value_is_not_copied() -> None:
    file = _Parts()
    written(file)
    views = [part.obj for part in file.given if isinstance(part, memoryview)]
    assert all(one is other for one, other in zip(views, LARGE, strict=True))


class _Disk(io.BytesIO):
    """Has room for so many bytes, and takes what fits before it fails."""

    def __init__(self, room: int) -> None:
        super().__init__()
        self.room = room

    def writelines(self, lines: Any) -> None:
        data = b"".join(lines)
        fits = data[: self.room - self.tell()]
        self.write(fits)
        if len(fits) < len(data):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize(("room", "chunks"), [(100_000, 0), (700_000, 1), (1_000_000, 1)])
def test_a_full_disk_leaves_what_was_written_before(room: int, chunks: int) -> None:
    disk = _Disk(room)
    writer = McapWriter(disk, "test", "rtkit")
    image = writer.add_channel("image", 0, {}, is_compressed=False)
    with pytest.raises(OSError, match="No space left"):
        add_all(writer, image)
    before = disk.getvalue()
    assert len(before) == room
    disk.room *= 2  # a summary would not belong to what is there
    writer.finish()
    assert disk.getvalue() == before
    found = chunks_until_broken(before)
    assert [each.data.count(LARGE[1]) for each in found] == [1] * chunks


def add_all(writer: McapWriter, channel: int) -> None:
    for number, value in enumerate(LARGE):
        writer.add_value(channel, 0, number, number, value)


def chunks_until_broken(data: bytes) -> list[Chunk]:
    from mcap.exceptions import EndOfFile

    found = []
    try:
        for record in StreamReader(io.BytesIO(data), emit_chunks=True).records:
            if isinstance(record, Chunk):
                found.append(record)
    except EndOfFile:
        pass
    return found
