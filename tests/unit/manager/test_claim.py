"""The lock of a manager's name, and what lies in the way of it."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from rtkit.container.heartbeats import Heartbeats
from rtkit.container.orphans import end_sessions
from rtkit.errors import Refused
from rtkit.link import places, running
from rtkit.manager import claim
from rtkit.manager.predecessor.stale_resources import end_remains
from rtkit.manager.predecessor.unreported import living_slaves

TAKE = """
from contextlib import ExitStack
from rtkit.manager.claim import take_lock
with ExitStack() as stack:
    take_lock("m", stack)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    tmp_path.chmod(0o700)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    return tmp_path


def take_elsewhere() -> str:
    done = subprocess.run([sys.executable, "-c", TAKE], capture_output=True, text=True, check=False)
    return done.stderr


def test_a_name_is_taken_once(folder: Path) -> None:
    with ExitStack() as stack:
        claim.take_lock("m", stack)
        assert f"manager 'm' is running already (pid {os.getpid()})" in take_elsewhere()
    assert take_elsewhere() == ""
    assert list(folder.iterdir()) == []


def test_who_looks_whether_it_runs_itself_keeps_its_lock(folder: Path) -> None:
    """Closing any descriptor of a locked file frees the lock of the whole process."""
    with ExitStack() as stack:
        claim.take_lock("m", stack)
        assert running.managers() == ["m"]
        assert places.owner("m") == os.getpid()
        assert "is running already" in take_elsewhere()


def host_elsewhere() -> str:
    code = "from rtkit.link import places; print(places.host_name())"
    return subprocess.check_output([sys.executable, "-c", code], text=True).strip()


def test_what_runs_beside_a_manager_has_its_name_of_the_host(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RTKIT_MANAGER", "m")
    monkeypatch.setenv("RTKIT_HOSTNAME", "robot1")
    with ExitStack() as stack:
        claim.take_lock("m", stack)
        monkeypatch.delenv("RTKIT_HOSTNAME")
        assert host_elsewhere() == "robot1"
        assert places.host_name() == os.uname().nodename
        assert "is running already" in take_elsewhere(), "who asks for the name keeps its lock"
        monkeypatch.setenv("RTKIT_HOSTNAME", "robot2")
        assert host_elsewhere() == "robot2"
        monkeypatch.delenv("RTKIT_HOSTNAME")
    assert host_elsewhere() == os.uname().nodename


def test_who_is_the_manager_is_not_it_twice(folder: Path) -> None:
    with ExitStack() as stack:
        claim.take_lock("m", stack)
        with ExitStack() as other, pytest.raises(Refused, match="is running already"):
            claim.take_lock("m", other)
        assert "is running already" in take_elsewhere()


def test_a_lock_that_was_removed_is_not_removed_from_the_next_one(folder: Path) -> None:
    with ExitStack() as stack:
        claim.take_lock("m", stack)
        (folder / "m.lock").unlink()
        (folder / "m.lock").touch()
    assert (folder / "m.lock").exists()


def test_a_manager_whose_lock_was_removed_is_not_replaced(folder: Path) -> None:
    claim.check_silence("m")
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(folder / "m.ctl"))
        claim.check_silence("m")
        listener.listen()
        with pytest.raises(Refused, match=rf"running already \(pid {os.getpid()}\), its lock was"):
            claim.check_silence("m")
    claim.check_silence("m")


def test_a_lock_that_cannot_be_had_at_all(folder: Path) -> None:
    (folder / "m.lock").mkdir()
    with ExitStack() as stack, pytest.raises(Refused, match=r"cannot open lock file .*m\.lock"):
        claim.take_lock("m", stack)


def test_what_is_stale_is_removed_and_what_is_not_ours_is_named(folder: Path) -> None:
    child = os.fork()
    if not child:
        os._exit(0)
    os.waitpid(child, 0)
    own = os.getpid()
    parent = os.getppid()  # it has that pid, but did not make the socket
    for name in (f"m.{child}.data", f"m.{parent}.data", f"m.{child}.x", "other.1.data"):
        (folder / name).touch()
    guest = socket.socket(socket.AF_UNIX)
    guest.bind(str(folder / f"m.{own}.data"))
    slave = Heartbeats(str(folder / f"m.{own}.beats"))
    for pid in (own, os.getppid()):
        (folder / f"m.{pid}.held").touch()
    assert living_slaves("m") == {own}
    claim.remove_stale("m", living_slaves("m"))
    left = sorted(each.name for each in folder.iterdir())
    kept = [f"m.{own}.{kind}" for kind in ("beats", "data", "held")]
    assert left == sorted([*kept, f"m.{child}.x", "other.1.data"])
    guest.close()
    del slave
    assert living_slaves("m") == set()
    (folder / "m.sock").mkdir()
    with pytest.raises(Refused, match=r"not a socket, remove it yourself: .*m\.sock"):
        claim.remove_stale("m", ())
    (folder / "m.sock").rmdir()
    (folder / "m.sock.lock").mkdir()
    with pytest.raises(Refused, match=r"cannot remove .*m\.sock\.lock: Is a directory"):
        claim.remove_stale("m", ())


@pytest.fixture
def stranger() -> subprocess.Popen[bytes]:
    """A process of somebody else's, with a session of its own."""
    with subprocess.Popen(["sleep", "60"], start_new_session=True) as process:
        yield process
        process.kill()


def test_a_stranger_with_the_pid_of_a_slave_is_not_ended(
    folder: Path, stranger: subprocess.Popen[bytes]
) -> None:
    (folder / f"m.{stranger.pid}.beats").touch()
    assert end_remains("m") == 0
    end_sessions({stranger.pid})
    end_sessions({stranger.pid}, is_heir=False)
    assert stranger.poll() is None


def test_what_is_left_of_a_manager_that_runs_is_its_own(folder: Path) -> None:
    with ExitStack() as stack:
        claim.take_lock("m", stack)
        with pytest.raises(Refused, match="is running already"):
            end_remains("m")


def test_what_a_component_run_by_hand_shows_goes_when_it_is_dead(folder: Path) -> None:
    with subprocess.Popen(["true"]) as done:
        done.wait()
    dead, alive = folder / f"m.{done.pid}.guest.beats", folder / f"m.{os.getpid()}.guest.beats"
    for path in (dead, alive):
        Heartbeats(str(path))
    assert living_slaves("m") == set()
    claim.remove_stale("m", ())
    assert list(folder.iterdir()) == [alive]
