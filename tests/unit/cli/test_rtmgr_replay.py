"""``rtmgr replay``: what is shown of a dump, and of files that are none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jsonrecords
import pytest
from fake_shell import FakeShell

from rtkit.cli.managers.rtmgr import main
from rtkit.deployment.actions import Create
from rtkit.manager.core import events as ev
from rtkit.manager.core.dump import Dump, to_lines
from rtkit.manager.core.event_ring import Fault
from rtkit.version import __version__

HEADER = {
    "manager": "robot",
    "host": "h",
    "pid": "7",
    "rtkit": __version__,
    "time": "now",
    "why": "fault in timer: KeyError: 1",
}


@pytest.fixture
def shell() -> FakeShell:
    shell = FakeShell(ring_size=1000)
    shell.make("A", "s")
    assert shell.ring is not None
    shell.ring.note(Fault("timer", "KeyError: 1", "Traceback\n  line 7\x1b[31m"))
    return shell


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "robot.dump"


def write(shell: FakeShell, file: Path, **header: str) -> str:
    assert shell.ring is not None
    file.write_text("\n".join(to_lines(Dump(HEADER | header, shell.ring.capture()))))
    return str(file)


def test_what_was_done_is_shown_and_the_fault(shell: Any, file: Path, capsys: Any) -> None:
    assert main(["replay", write(shell, file)]) == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert err == ""
    assert lines[:2] == [
        "fault in timer: KeyError: 1 (now)",
        "manager robot on h, pid 7; 0 earlier events are not here",
    ]
    assert lines[2].startswith("  0.000000  BatchRequested(batch=Batch(actions=(Create(")
    assert "            -> SpawnSlave(key=1, name='s', ahead=())" in lines
    assert "  0.000000  FAULT in timer: KeyError: 1" in lines
    assert "\x1b" not in out
    assert lines[-1] == "the end: 2 processes, 1 component, 0 connectors, as in the manager"


def test_long_lines_are_cut_unless_all_is_wanted(shell: Any, file: Path, capsys: Any) -> None:
    shell.ask(Create("Thing?instance_name=B&note=" + "x" * 1000))
    path = write(shell, file)
    main(["replay", path])
    assert max(map(len, capsys.readouterr().out.splitlines())) == 300
    main(["-v", "replay", path])
    assert max(map(len, capsys.readouterr().out.splitlines())) > 1000


def test_another_end_is_told(shell: Any, file: Path, capsys: Any) -> None:
    shell.state.masters.append("someone")  # past the core, as nothing may
    assert main(["replay", write(shell, file)]) == 1
    assert capsys.readouterr().out.splitlines()[-2:] == [
        "the end: 2 processes, 1 component, 0 connectors; other than in the manager:",
        "  state.masters: is None, was ['someone']",
    ]


def test_another_version_is_noted(shell: Any, file: Path, capsys: Any) -> None:
    assert main(["replay", write(shell, file, rtkit="9.9")]) == 0
    assert capsys.readouterr().err == "rtmgr: note: of rtkit 9.9; this one may do otherwise\n"


def test_as_a_record(shell: Any, file: Path, capsys: Any) -> None:
    assert main(["replay", "--json", write(shell, file)]) == 0
    (record,) = jsonrecords.checked(capsys.readouterr().out)
    assert record["schema"] == "rtkit.replay/1"
    assert record["faults"] == [{"work": "timer", "error": "KeyError: 1"}]
    assert record["differences"] == []
    assert record["events"] > 5


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"\xff\xfe\x00", "not a dump of a manager: not UTF-8 (invalid start byte)"),
        (b"", "not a whole dump of a manager: it ends after line 0"),
        (b"rubbish", "not a dump of a manager, line 1: not JSON"),
    ],
)
def test_rubbish_is_refused(content: bytes, why: str, file: Path, capsys: Any) -> None:
    file.write_bytes(content)
    assert main(["replay", str(file)]) == 1
    assert capsys.readouterr().err.startswith(f"rtmgr: {file}: {why}")


def test_a_file_that_is_cut_off_at_any_line_is_refused(shell: Any, file: Path, capsys: Any) -> None:
    lines = Path(write(shell, file)).read_text().splitlines()
    for count in range(len(lines)):
        file.write_text("\n".join(lines[:count]) + lines[count][:20])
        assert main(["replay", str(file)]) == 1
        assert capsys.readouterr().err.startswith(f"rtmgr: {file}: not a ")


def test_what_has_no_beginning_is_told(file: Path, capsys: Any) -> None:
    shell = FakeShell(ring_size=10)
    shell.ask(Create("Thing?instance_name=A&manager_name=s"))
    for _ in range(20):
        shell.feed(ev.TimerExpired())
    assert main(["replay", write(shell, file)]) == 1
    assert "not at rest for as long as its ring reaches" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "status", "why"),
    [
        (["replay"], 2, "replay takes the file of a dump"),
        (["replay", "a", "b"], 1, "takes one file, not also: b"),
        (["replay", "/nowhere/x"], 1, "cannot read /nowhere/x: No such file or directory"),
        (["replay", "/"], 1, "cannot read /: Is a directory"),
        (["dump", "a", "b", "c"], 1, "takes one file, not also: c"),
        (["dump", "a/b"], 1, "a/b"),
    ],
)
def test_lines_that_make_no_sense(line: list[str], status: int, why: str, capsys: Any) -> None:
    assert main(line) == status
    assert why in capsys.readouterr().err
