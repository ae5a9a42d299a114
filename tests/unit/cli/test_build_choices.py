"""``rtbuild --diff``, ``--keep``, ``--replace``, ``--merge``: one decision for each file."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonrecords
import pytest

Run = Callable[[str], Any]


class _Stdin:
    def __init__(self, text: str) -> None:
        self.buffer = io.BytesIO(text.encode())


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Run) -> Path:
    """A folder with a component whose generated part, and whose own code, were changed."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "Gain").mkdir()
    run("rtprofile new component Gain --in in:TimedLong --out out:TimedLong -o Gain/RTC.xml")
    assert run("rtbuild Gain/RTC.xml").status == 0
    code = tmp_path / "Gain/Gain.py"
    text = code.read_text().replace("from rtkit", "# mine\nfrom rtkit", 1)
    mark = "<user code on_initialize>\n"
    code.write_text(text.replace(mark, f"{mark}        self.mine = 1\n"))
    assert "# mine" in code.read_text()
    return tmp_path


def drafted(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Give on stdin the profile of the folder with one port more."""
    text = (place / "Gain/RTC.xml").read_text()
    port = '<rtc:DataPorts xsi:type="rtcExt:dataport_ext" rtc:portType="DataInPort" rtc:name="more"'
    port += ' rtc:type="RTC::TimedLong" rtcExt:position="LEFT"/>'
    at = text.index("<rtc:DataPorts")
    monkeypatch.setattr(sys, "stdin", _Stdin(text[:at] + port + text[at:]))


def test_differences_are_shown_and_nothing_is_written(
    place: Path, monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    before = (place / "Gain/Gain.py").read_text()
    drafted(place, monkeypatch)
    done = run("rtbuild --diff --json -o Gain -")
    records = jsonrecords.checked(done.out)
    assert {jsonrecords.kind_of(record) for record in records} == {"built-difference"}
    found = {each["name"]: each for each in records}
    code = found["Gain.py"]
    assert (code["fate"], code["why"], code["before"]) == (
        "conflict", "the generated part was changed", before,
    )  # fmt: skip
    assert "more" in code["after"]
    assert "# mine" not in code["after"]
    assert "more" in code["merged"]
    assert "# mine\n" in code["merged"]
    assert (place / "Gain/Gain.py").read_text() == before
    drafted(place, monkeypatch)
    text = run("rtbuild --diff -o Gain -").out
    assert "--- Gain/Gain.py\n+++ Gain/Gain.py\n" in text
    assert "\n-# mine\n" in text


def test_a_conflict_is_merged(place: Path, monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    drafted(place, monkeypatch)
    assert run("rtbuild -o Gain -").status == 1
    drafted(place, monkeypatch)
    assert run("rtbuild -o Gain --merge Gain.py --replace RTC.xml -").status == 0
    text = (place / "Gain/Gain.py").read_text()
    assert "# mine\n" in text
    assert "self.mine = 1" in text
    assert "more" in text
    assert "# mine\n" in (place / "Gain/Gain.py.bak").read_text()
    compile(text, "Gain.py", "exec")
    again = run("rtbuild -v -o Gain --merge Gain.py Gain/RTC.xml")
    assert (again.status, "unchanged  Gain/Gain.py" in again.out) == (0, True)
    assert not (place / "Gain/Gain.py.bak2").exists()


def test_a_file_is_kept_or_replaced(place: Path, monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    before = (place / "Gain/Gain.py").read_text()
    drafted(place, monkeypatch)
    assert run("rtbuild -o Gain --keep Gain.py -").status == 0
    assert (place / "Gain/Gain.py").read_text() == before
    drafted(place, monkeypatch)
    assert run("rtbuild -o Gain --replace Gain.py -").status == 0
    after = (place / "Gain/Gain.py").read_text()
    assert "# mine" not in after
    assert "self.mine = 1" in after  # code between marks is never lost
    assert (place / "Gain/Gain.py.bak").read_text() == before


def test_what_cannot_be_chosen_is_told(place: Path, run: Run) -> None:
    done = run("rtbuild Gain/RTC.xml --keep Other.py")
    assert (done.status, "Other.py is not generated" in done.err) == (1, True)
    (place / "Gain/README.md").write_text("mine\n")
    done = run("rtbuild Gain/RTC.xml --keep Gain.py --merge README.md")
    assert (done.status, "README.md cannot be merged" in done.err) == (1, True)
