"""Why a manager cannot be reached, and what would help."""

from __future__ import annotations

import socket
import subprocess
import sys
from pathlib import Path

import pytest

from rtkit.link.running import managers, why_absent


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("RTKIT_MANAGER", raising=False)
    tmp_path.chmod(0o700)
    return tmp_path


def test_the_start_is_of_the_one_that_was_asked(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert why_absent("manager").endswith("is not running (start it with: rtmgr start)")
    assert why_absent("b").endswith("'b' is not running (start it with: rtmgr start b)")
    assert why_absent("a b").endswith("(start it with: rtmgr start 'a b')")
    monkeypatch.setenv("RTKIT_MANAGER", "b")
    assert why_absent("manager").endswith("(start it with: rtmgr start manager)")


def test_who_asks_from_another_host_is_told_the_start_from_there(folder: Path) -> None:
    assert why_absent("manager", "fa").endswith("(start it with: rtmgr start --host fa)")
    assert why_absent("arm", "fa").endswith("(start it with: rtmgr start arm --host fa)")


HOLD = """
import fcntl, os, sys
lock = os.open(sys.argv[1], os.O_RDWR | os.O_CREAT, 0o600)
fcntl.lockf(lock, fcntl.LOCK_EX)
print("held", flush=True)
sys.stdin.read()
"""


def test_others_that_run_are_named(folder: Path) -> None:
    command = [sys.executable, "-c", HOLD, str(folder / "other.lock")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"held\n"
        assert managers() == ["other"]
        assert why_absent("b").endswith("(start it with: rtmgr start b; running: other)")
        holder.communicate()
    assert managers() == []


def test_a_dead_socket_is_named(folder: Path) -> None:
    path = folder / "manager.sock"
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind(str(path))
    where = f"{path} (start it with: rtmgr start)"
    told = f"manager 'manager' is not running: nobody is behind its socket {where}"
    assert why_absent("manager") == told
    path.unlink()
    path.touch()
    assert why_absent("manager").endswith(f"{path} is no socket (remove it, then: rtmgr start)")


@pytest.mark.parametrize("mode", [0o755, 0o777, 0o000, 0o500])
def test_wrong_permissions_are_named_with_the_cure(folder: Path, mode: int) -> None:
    folder.chmod(mode)
    told = why_absent("manager")
    assert told.startswith("manager 'manager' cannot be reached: ")
    assert told.endswith(f": {folder} (repair it with: chmod 700 {folder})")
    folder.chmod(0o700)


def test_a_folder_that_is_none(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "file").touch()
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(folder / "file"))
    end = f"not a folder: {folder}/file (choose another one with RTKIT_RUNTIME_DIR)"
    assert why_absent("manager").endswith(end)
