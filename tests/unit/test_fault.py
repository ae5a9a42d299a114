"""Named points: nothing without orders, and what was ordered with them; who may be broken off."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from rtkit import fault
from rtkit.errors import Refused


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    tmp_path.chmod(0o700)
    monkeypatch.setattr(fault, "_FOLDER", str(tmp_path))
    return tmp_path


def test_without_a_folder_nothing_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fault, "_FOLDER", "")
    monkeypatch.chdir(tmp_path)
    fault.point("a")
    fault.check(is_allowed=False)
    assert list(tmp_path.iterdir()) == []


def test_passes_are_noted(folder: Path) -> None:
    fault.point("a")
    fault.point("b")
    fault.point("a")
    own = os.getpid()
    assert (folder / "passed").read_text() == f"a {own}\nb {own}\na {own}\n"
    assert not (folder / "struck").exists()


def test_practice_does_not_count(folder: Path) -> None:
    with fault.unheeded():
        fault.point("a")
    assert list(folder.iterdir()) == []
    fault.point("a")
    assert (folder / "passed").exists()


def test_an_order_is_for_one_pass(folder: Path) -> None:
    (folder / "orders").write_text("a 2 raise ENOSPC\nb 1 delay 0\n")
    fault.point("a")
    with pytest.raises(OSError, match="No space left"):
        fault.point("a")
    fault.point("a")
    fault.point("b")
    own = os.getpid()
    assert (folder / "struck").read_text() == f"a 2 {own} raise\nb 1 {own} delay\n"


def test_passes_of_all_processes_count(folder: Path) -> None:
    (folder / "orders").write_text("a 2 kill\n")
    fault.point("a")
    child = os.fork()
    if not child:
        fault.point("a")
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


def test_an_order_that_is_unknown_is_no_silence(folder: Path) -> None:
    (folder / "orders").write_text("a 1 explode\n")
    with pytest.raises(ValueError, match="unknown action: explode"):
        fault.point("a")


def test_root_s_daemon_wants_to_be_allowed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: os.stat(folder).st_uid)
    if os.getuid() != 0:
        fault.check(is_allowed=False)
        return
    with pytest.raises(Refused, match="--allow-faults"):
        fault.check(is_allowed=False)
    fault.check(is_allowed=True)


def test_orders_of_others_are_not_heeded(folder: Path) -> None:
    folder.chmod(0o770)
    with pytest.raises(Refused, match="open to them"):
        fault.check(is_allowed=True)
    folder.chmod(0o700)
    folder.rename(folder.with_name("away"))
    with pytest.raises(Refused, match="names no folder"):
        fault.check(is_allowed=True)
