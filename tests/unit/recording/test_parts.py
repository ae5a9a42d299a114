"""Which entries of a recording are wanted; text logs; stamps; schemas."""

from __future__ import annotations

import re
from dataclasses import is_dataclass
from pathlib import Path

import pytest

from rtkit.component import Time, TimedLong
from rtkit.component.geometry import Point2D
from rtkit.component.standard import SCOPES, names_of
from rtkit.component.values.codec import codec_for
from rtkit.component.values.definition import idl_of, name_of
from rtkit.component.values.typenames import type_by_name
from rtkit.errors import Malformed, Refused
from rtkit.idl.read import read_idl
from rtkit.probe.stats import stamp_reader
from rtkit.recording.entries import RecordedValue, RecordingSelection
from rtkit.recording.text_log import line_of, read_file, read_lines
from rtkit.recording.time_stamps import shifted

FIVE = [RecordedValue("a", 100 + number, 0, b"") for number in range(5)]


@pytest.mark.parametrize(
    ("part", "wanted"),
    [
        (RecordingSelection(), [0, 1, 2, 3, 4]),
        (RecordingSelection(2, None, True), [2, 3, 4]),
        (RecordingSelection(None, 3, True), [0, 1, 2]),
        (RecordingSelection(2, 2, True), [2]),
        (RecordingSelection(102, None), [2, 3, 4]),
        (RecordingSelection(None, 102), [0, 1, 2]),
        (RecordingSelection(101, 103), [1, 2, 3]),
        (RecordingSelection(9, None, True), []),
        (RecordingSelection(105, None), []),
        (RecordingSelection(None, 99), []),
        (RecordingSelection(None, 0, True), []),
        (RecordingSelection(3, 2, True), []),
        (RecordingSelection(103, 102), []),
    ],
)
def test_parts(part: RecordingSelection, wanted: list[int]) -> None:
    assert [entry.time_ns - 100 for entry in part.of(FIVE)] == wanted
    assert bool(wanted) is not _is_out(part)


def _is_out(part: RecordingSelection) -> bool:
    try:
        return bool(part.check(5, 100, 104))
    except Refused:
        return True


def test_text_lines_are_read_again() -> None:
    value = {"tm": {"sec": 1, "nsec": 5}, "data": [1.5, "ä'\""]}
    line = line_of("in put'", 1_000_000_005, value)
    assert line.startswith("1.000000005\t(")
    (found,) = read_lines([line + "\n", "\n"], "x.txt")
    assert found == ("in put'", 1_000_000_005, value)


def test_lines_of_other_tools_are_read_and_not_executed() -> None:
    text = "1.000000002\t('input0', RTC.TimedLong(tm=RTC.Time(sec=1, nsec=2), data=-3))"
    (found,) = read_lines([text], "x.txt")
    assert found.value == {"tm": {"sec": 1, "nsec": 2}, "data": -3}


@pytest.mark.parametrize(
    "line",
    [
        "hello",
        "1.0\t('a', 1)",
        "1.000000000\t('a', __import__('os').system('x'))",
        "1.000000000\t('a', open('/etc/passwd'))",
        "1.000000000\t('a', [x for x in y])",
        "1.000000000\t('a', " + "(" * 5000 + ")",
    ],
)
def test_what_is_no_line(line: str) -> None:
    with pytest.raises(Malformed, match=r"x\.txt:1"):
        list(read_lines([line], "x.txt"))


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"1.000000000\t('a', 1)\n\xff\xfe\n", ":2: no line of a text log: it is not UTF-8"),
        (b"\x89MCAP0\r\n", ": this is an MCAP file, no text log: -l mcap"),
    ],
)
def test_a_file_that_is_no_text_log_is_named(tmp_path: Path, data: bytes, told: str) -> None:
    file = tmp_path / "x.txt"
    file.write_bytes(data)
    with pytest.raises(Malformed, match=re.escape(f"{file}{told}")):
        list(read_file(str(file)))


def test_stamps_are_moved_and_nothing_else() -> None:
    stamp = stamp_reader(TimedLong)
    payload = codec_for(TimedLong).encode(TimedLong(Time(5, 6), 7))
    moved = shifted(payload, 5_000_000_006)
    assert codec_for(TimedLong).decode(moved).data == 7
    assert (stamp(moved) or 0) > 10**18
    point = codec_for(Point2D).encode(Point2D(1.0, 2.0))
    assert shifted(point, 1) == point
    assert shifted(b"", 1) == b""


NAMES = [f"{scope}::{each}" for scope in SCOPES for each in names_of(scope)]


@pytest.mark.parametrize("name", [each for each in NAMES if is_dataclass(type_by_name(each))])
def test_every_standard_type_has_a_schema_that_can_be_read(name: str) -> None:
    cls = type_by_name(name)
    assert cls is not None
    text = idl_of(cls)
    assert name_of(cls) == name
    assert read_idl(text).find(name) is not None
