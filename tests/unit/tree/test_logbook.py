"""Logs of several processes read as one, through rotation and torn lines."""

from __future__ import annotations

import json
import select
from pathlib import Path

import pytest

from rtkit.errors import Refused
from rtkit.logs.logbook import Logbook
from rtkit.logs.logfile import LogFile


def record(moment: int, message: str, component: str = "") -> bytes:
    fields = {
        "time": f"2026-01-01T00:00:{moment:02}.000000Z",
        "level": "INFO",
        "process": "p",
        "pid": 1,
        "component" if component else "logger": component or "rtkit",
        "message": message,
    }
    return json.dumps(fields).encode() + b"\n"


def messages(entries: list[object]) -> list[str]:
    return [each.message for each in entries]  # type: ignore[attr-defined]


@pytest.fixture
def files(tmp_path: Path) -> tuple[LogFile, LogFile]:
    return LogFile(str(tmp_path / "m.log"), 400), LogFile(str(tmp_path / "m.s.log"), 400)


def test_what_is_there_comes_in_order_of_time(
    tmp_path: Path, files: tuple[LogFile, LogFile]
) -> None:
    for moment in range(12):
        files[moment % 2].write(record(moment, str(moment)))
    assert (tmp_path / "m.log.1").exists()
    book = Logbook(str(tmp_path), lambda entry: True)
    assert messages(book.there()) == [str(number) for number in range(12)]
    book.close()
    book = Logbook(str(tmp_path), lambda entry: entry.file == "m.s")
    assert messages(book.there(2)) == ["9", "11"]
    assert messages(book.there(0)) == []
    book.close()


def test_what_comes_is_told_once_through_a_turn_over(
    tmp_path: Path, files: tuple[LogFile, LogFile]
) -> None:
    files[0].write(record(0, "before"))
    book = Logbook(str(tmp_path), lambda entry: True)
    assert messages(book.there()) == ["before"]
    found: list[str] = []
    for moment in range(1, 20):
        files[moment % 2].write(record(moment, str(moment)))
        if moment % 3 == 0:
            assert select.select([book], [], [], 10.0)[0]
            found += messages(book.delta())
    found += messages(book.delta())
    assert found == [str(number) for number in range(1, 20)]
    assert not select.select([book], [], [], 0)[0]
    book.close()


def test_lines_that_are_no_records_are_counted(tmp_path: Path) -> None:
    (tmp_path / "m.log").write_bytes(b'{"half\n[]\n{}\n\n' + record(1, "whole", "A"))
    book = Logbook(str(tmp_path), lambda entry: True)
    (entry,) = book.there()
    assert (entry.component, entry.source, book.unreadable) == ("A", "A", 3)
    book.close()


def test_a_line_that_is_being_written_waits_for_its_end(tmp_path: Path) -> None:
    path = tmp_path / "m.log"
    line = record(1, "whole")
    path.write_bytes(line[:20])
    book = Logbook(str(tmp_path), lambda entry: True)
    assert book.there() == []
    with path.open("ab") as file:
        file.write(line[20:])
    assert messages(book.delta()) == ["whole"]
    book.close()


def test_no_folder(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="No such file"):
        Logbook(str(tmp_path / "none"), lambda entry: True)
