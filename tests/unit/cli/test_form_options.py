"""Forms of system profiles, in every command that reads or writes one: options, names, content."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager

Run = Callable[[str], Any]
OUT, INTO = "/localhost/local.host_cxt/Output0.rtc:out", "/localhost/Std0.rtc:in"


@pytest.fixture
def saved(run: Run, tmp_path: Path) -> Path:
    """What rtcryo -y makes of one connection."""
    file = tmp_path / "system.yaml"
    assert run(f"rtcon -i wire {OUT} {INTO}").status == 0
    assert run(f"rtcryo -y -n Demo -e Me -v 2 -a 'a: b' -o {file}")[:2] == (0, "")
    return file


def test_yaml_is_written(saved: Path) -> None:
    lines = saved.read_text().splitlines()
    assert lines[:4] == [
        "rtsProfile:",
        "  id: RTSystem:Me:Demo:2",
        "  version: '0.2'",
        "  abstract: 'a: b'",
    ]


def test_what_was_saved_comes_back(world: FakeManager, run: Run, saved: Path) -> None:
    assert run(f"rtcheck --yaml -s inactive {saved}") == (0, "", "")
    assert run(f"rtteardown -y {saved}") == (0, "", "")
    assert world.connectors == {}
    assert run(f"rtresurrect -y {saved}") == (0, "", "")
    assert sorted(world.connectors) == ["wire"]
    assert run(f"rtstart -y {saved}").status == 0
    assert [world.state_of(name) for name in ("Output0", "Std0")] == ["Active"] * 2
    assert run(f"rtstop -y {saved}").status == 0


def test_it_is_the_same_as_in_xml(run: Run, saved: Path, tmp_path: Path) -> None:
    xml = tmp_path / "system.xml"
    assert run(f"rtcryo -o {xml}").status == 0
    assert xml.read_text().startswith("<?xml")
    told = run(f"rtresurrect --dry-run {xml}")
    assert told.out.count("\n") > 3
    assert run(f"rtresurrect --dry-run -y {saved}") == told


@pytest.mark.parametrize(
    ("option", "name", "begins"),
    [
        ("", "system.yml", "rtsProfile:"),
        ("", "system.json", "{"),
        ("", "system.xml", "<?xml"),
        ("", "system", "<?xml"),
        ("-x", "system.yaml", "<?xml"),
        ("-y", "system.xml", "rtsProfile:"),
        ("--json", "system", "{"),
    ],
)
def test_every_form_is_written_and_known_again(
    run: Run, saved: Path, tmp_path: Path, option: str, name: str, begins: str
) -> None:
    file = tmp_path / name
    assert run(f"rtcryo {option} -o {file}").status == 0
    assert file.read_text().startswith(begins)
    forced = "-y " if option == "-y" else ""
    assert run(f"rtcheck {forced}-s inactive {file}") == (0, "", "")


@pytest.mark.parametrize(("options", "status"), [("", 0), ("-y", 0), ("-x -y", 0), ("-y -x", 1)])
def test_stdin_and_the_last_of_both_options(
    run: Run, saved: Path, monkeypatch: pytest.MonkeyPatch, options: str, status: int
) -> None:
    text = io.TextIOWrapper(io.BytesIO(saved.read_bytes()))
    monkeypatch.setattr(sys, "stdin", text)
    assert run(f"rtresurrect --dry-run {options}").status == status


def test_what_is_wrong_is_told_with_its_line(run: Run, saved: Path) -> None:
    saved.write_text("rtsProfile:\n  id: !x y\n")
    why = f"rtcheck: {saved}:2: tag '!x' is not allowed: a profile is plain data\n"
    assert run(f"rtcheck -y {saved}") == (1, "", why)
    assert run(f"rtcheck -y --exit-detail {saved}").status == 3
