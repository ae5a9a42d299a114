"""Recordings as MCAP files."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from mcap.reader import make_reader

from rtkit.component import Time, TimedLong
from rtkit.component.values.codec import codec_for
from rtkit.component.values.definition import idl_of
from rtkit.errors import Malformed
from rtkit.recording.entries import RecordedStream, RecordedValue
from rtkit.recording.mcap_file import RecordingReader, RecordingWriter

ENCODE = codec_for(TimedLong).encode
_BEGUN = 40
"""Bytes of a file after which it is known for a recording."""
LONG = RecordedStream("a", "RTC::TimedLong", ("/localhost/A.rtc:out", "/localhost/B.rtc:out"))


def entry(number: int, channel: str = "a") -> RecordedValue:
    stamp = 10**18 + number
    return RecordedValue(channel, stamp, stamp + 7, ENCODE(TimedLong(Time(), number)))


def recorded(path: Path, count: int, chunk: int = 5) -> list[RecordedValue]:
    entries = [entry(number) for number in range(count)]
    with path.open("wb") as file, RecordingWriter(file) as writer:
        writer.add_channel(LONG, TimedLong)
        for number, each in enumerate(entries):
            writer.write(each)
            if number % chunk == chunk - 1:
                writer.flush()
    return entries


def test_what_is_written_is_read(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    entries = recorded(path, 23)
    assert list(RecordingReader(str(path)).entries()) == entries
    info = RecordingReader(str(path)).info()
    known = LONG._replace(definition=idl_of(TimedLong))
    assert (info.entries, info.is_whole, info.channels) == (23, True, (known,))
    assert (info.first_ns, info.last_ns) == (entries[0].time_ns, entries[-1].time_ns)
    assert info.began_ns > 10**18


def test_a_stream_without_values_is_told(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    quiet = RecordedStream("quiet", "RTC::TimedLong", ("/localhost/C.rtc:out",))
    with path.open("wb") as file, RecordingWriter(file) as writer:
        writer.add_channel(LONG, TimedLong)
        writer.write(entry(1))
        writer.flush()
        writer.add_channel(quiet, TimedLong)  # it came when no value did any more
    info = RecordingReader(str(path)).info()
    assert {each.name: each.sources for each in info.channels} == {
        "a": LONG.sources,
        "quiet": quiet.sources,
    }
    assert (info.counts, info.is_whole) == ({"a": 1, "quiet": 0}, True)
    data = path.read_bytes()
    summary = data.rindex(b"quiet")  # what is broken behind the values spoils none of them
    path.write_bytes(data[: summary - 9] + b"\xff" * 9 + data[summary:])
    assert RecordingReader(str(path)).info().counts["a"] == 1


def test_a_stock_reader_opens_it(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    entries = recorded(path, 12)
    with path.open("rb") as file:
        found = list(make_reader(file, validate_crcs=True).iter_messages())
    assert [message.data for _, _, message in found] == [each.payload for each in entries]
    schema, channel, _ = found[0]
    assert schema is not None
    assert (schema.name, schema.encoding, channel.topic) == ("RTC::TimedLong", "omgidl", "a")
    assert b"struct TimedLong" in schema.data


def test_a_file_that_was_cut_anywhere_gives_what_stands_before(tmp_path: Path) -> None:
    path, cut = tmp_path / "x.mcap", tmp_path / "cut.mcap"
    entries = recorded(path, 15)
    whole = path.read_bytes()
    seen = set()
    for size in range(_BEGUN, len(whole)):
        cut.write_bytes(whole[:size])
        found = list(RecordingReader(str(cut)).entries())
        assert found == entries[: len(found)]
        seen.add(len(found))
    assert seen == {0, 5, 10, 15}
    cut.write_bytes(whole[: len(whole) // 2])
    assert not RecordingReader(str(cut)).info().is_whole


@pytest.mark.parametrize("content", [b"", b"hi", b"\x89MCAP0\r\n", bytes(1000)])
def test_what_is_no_recording(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x"
    path.write_bytes(content)
    with pytest.raises(Malformed, match=r"^no recording: \S+: (not MCAP|it is empty)$"):
        RecordingReader(str(path)).info()


def test_a_chunk_is_due_soon_after_its_first_value() -> None:
    writer = RecordingWriter(io.BytesIO())
    writer.add_channel(LONG, TimedLong)
    assert writer.flush_at is None
    writer.write(entry(0))
    assert writer.flush_at is not None
    writer.flush()
    assert writer.flush_at is None


@pytest.mark.parametrize(
    ("definition", "encoding"), [("module V { union T switch", "omgidl"), ("", "")]
)
def test_a_stream_of_bytes_has_the_schema_that_there_is(
    tmp_path: Path, definition: str, encoding: str
) -> None:
    path = tmp_path / "x.mcap"
    stream = RecordedStream("a", "IDL:V/T:1.0", ("/localhost/A.rtc:out",), definition)
    with path.open("wb") as file, RecordingWriter(file) as writer:
        writer.add_channel(stream, bytes)
        writer.add_channel(RecordedStream("b", "any"), bytes)
        writer.write(RecordedValue("a", 1, 1, b"xyz"))
        writer.write(RecordedValue("b", 2, 2, b""))
    with path.open("rb") as file:
        (schema, _, _), (none, _, _) = make_reader(file, validate_crcs=True).iter_messages()
    assert none is None
    assert schema is not None
    assert (schema.name, schema.encoding) == ("V::T", encoding)
    assert schema.data.decode() == definition
    info = RecordingReader(str(path)).info()
    assert info.channels[0] == stream._replace(data_type="V::T")


def test_time_stamps_of_another_clock_are_put_right(tmp_path: Path) -> None:
    stream = LONG._replace(clock="robot1", offset_s=30.25, bound_s=0.001)
    payload = codec_for(TimedLong).encode(TimedLong(Time(1_000_030, 250_000_000), 7))
    with open(tmp_path / "run.mcap", "xb") as file, RecordingWriter(file) as writer:
        writer.add_channel(stream, TimedLong)
        writer.write(RecordedValue("a", 1_000_030_250_000_000, 5, payload))
        writer.write(RecordedValue("a", 9, 9, payload))  # of no stamp: when it arrived, here
    reader = RecordingReader(str(tmp_path / "run.mcap"))
    assert reader.info().channels == (stream._replace(definition=idl_of(TimedLong)),)
    first, second = reader.entries()
    assert (first.time_ns, first.offset_ns) == (1_000_000_000_000_000, 30_250_000_000)
    assert (second.time_ns, second.offset_ns) == (9, 0)
    assert first.payload == payload


@pytest.mark.parametrize("text", ["", "soon", "nan", "inf", "1e300", "-1e300"])
def test_an_offset_of_no_sense_is_none(tmp_path: Path, text: str) -> None:
    from rtkit.recording import mcap_file

    assert mcap_file._number(text) == 0.0
