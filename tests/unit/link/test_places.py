"""Folders that are this user's alone, paths that sockets can have, and who is the manager."""

from __future__ import annotations

import fcntl
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rtkit.errors import Refused
from rtkit.link import places, running
from rtkit.link.zenoh import unix_endpoint


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "folder"
    folder.mkdir(mode=0o700)
    return folder


def test_a_folder_that_is_missing_is_made_for_us_alone(tmp_path: Path) -> None:
    path = str(tmp_path / "a" / "b")
    old = os.umask(0)
    try:
        assert places.make_private(path) == path
    finally:
        os.umask(old)
    assert os.stat(path).st_mode & 0o777 == 0o700


@pytest.mark.parametrize("mode", [0o701, 0o710, 0o704, 0o777, 0o750])
def test_a_folder_that_is_open_to_others(folder: Path, mode: int) -> None:
    folder.chmod(mode)
    with pytest.raises(Refused, match=f"open to other users \\(mode {mode:o}\\): {folder}"):
        places.make_private(str(folder))


def test_a_folder_of_another_user(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: own + 1)
    with pytest.raises(Refused, match=f"belongs to another user: {folder}"):
        places.make_private(str(folder))


def test_a_folder_without_permission(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write everywhere
    with pytest.raises(Refused, match=f"no permission to write in folder: {folder}"):
        places.make_private(str(folder))


def test_what_is_no_folder(folder: Path) -> None:
    (folder / "file").write_text("")
    (folder / "link").symlink_to(folder)
    with pytest.raises(Refused, match=r"cannot use folder .*file: File exists"):
        places.make_private(str(folder / "file"))
    with pytest.raises(Refused, match=r"not a folder: .*link"):
        places.make_private(str(folder / "link"))
    with pytest.raises(Refused, match="cannot use folder"):
        places.make_private(str(folder / "file" / "below"))


@pytest.fixture
def another(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of sockets, looked at by a user who did not make it."""
    own = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: own + 1)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(folder))
    return folder


@pytest.mark.parametrize(
    "use",
    [
        places.services,
        running.managers,
        running.services,
        lambda: running.traces("manager"),
        lambda: places.owner("manager"),
        lambda: places.manager_socket("manager"),
        lambda: places.manager_lock("manager"),
        lambda: places.control_socket("manager"),
        lambda: places.service_socket("noise"),
        lambda: places.service_key_socket("noise"),
        lambda: places.data_socket("manager", 1),
        lambda: places.zygote_pattern("manager"),
        lambda: unix_endpoint(f"{places.runtime_path()}/noise.zps"),
    ],
)
def test_nothing_is_looked_for_in_a_folder_that_another_user_laid_out(
    another: Path, use: Callable[[], object]
) -> None:
    told = f"folder belongs to another user: {another} "
    with pytest.raises(Refused, match=re.escape(told)):
        use()


@pytest.mark.parametrize("mode", [0o770, 0o702, 0o777])
def test_nothing_is_looked_for_where_others_may_lay_sockets(
    folder: Path, mode: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("RTKIT_RUNTIME_DIR", raising=False)  # root may choose what it looks at
    folder.chmod(mode)
    with pytest.raises(Refused, match=f"open to other users \\(mode {mode:o}\\): {folder}"):
        places.check_trusted(str(folder))


def test_root_may_look_at_the_folder_that_it_chose(
    another: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "getuid", lambda: 0)
    assert places.runtime_dir() == str(another)


def test_logs_lie_beside_the_sockets_where_the_home_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.delenv("RTKIT_STATE_DIR", raising=False)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path / "run"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "home" / "state"))
    assert places.state_dir() == str(tmp_path / "home" / "state" / "rtkit")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file" / "state"))
    assert places.state_dir() == str(tmp_path / "run.state")
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path / "file" / "chosen"))
    assert places.state_dir() == str(tmp_path / "file" / "chosen")


def test_the_length_of_a_socket_s_path() -> None:
    for letter, count in (("x", 107), ("é", 53)):
        path = "/" + letter * (count - 1)
        assert places.check_socket_length(path) == path
    for path in ("/" + "x" * 107, "/" + "é" * 54):
        with pytest.raises(Refused, match="longer than 107 bytes, set RTKIT_RUNTIME_DIR"):
            places.check_socket_length(path)


@pytest.mark.parametrize("character", '#?"\\')
def test_characters_that_end_an_endpoint(character: str) -> None:
    with pytest.raises(Refused, match="not allowed"):
        places.check_socket_length(f"/run/a{character}b")


def test_who_holds_the_lock(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(folder))
    assert places.owner("manager") is None
    lock = Path(places.manager_lock("manager"))
    lock.write_text("4711\n")
    assert places.owner("manager") is None  # nobody holds it, whatever it says
    script = (
        "import fcntl, sys\n"
        f"file = open({str(lock)!r}, 'r+')\n"
        "fcntl.lockf(file, fcntl.LOCK_EX)\n"
        "print('locked', flush=True)\n"
        "sys.stdin.read()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"locked\n"
        assert places.owner("manager") == holder.pid
        with lock.open("r+") as file, pytest.raises(BlockingIOError):
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        holder.kill()
        holder.wait()
    assert places.owner("manager") is None
    lock.unlink()
    lock.symlink_to(folder / "elsewhere")
    assert places.owner("manager") is None


@pytest.mark.parametrize(
    ("pattern", "path"),
    [
        ("/run/manager.%p.data", "/run/manager.7.data"),
        ("/run/%p.%p.data", "/run/%p.7.data"),
        ("/run/manager.8.data", "/run/manager.8.data"),
    ],
)
def test_the_last_mark_of_a_pattern_is_the_pid(pattern: str, path: str) -> None:
    assert places.of_pid(pattern, 7) == path


@pytest.mark.parametrize(
    ("path", "found"),
    [("robots/r1.level", ["robots/r1"]), ("robots/r1/arm.x.y", ["robots/r1", "robots/r1/arm"]),
     ("//robots/./r1/level", ["robots/r1"]), ("/localhost/lamp.on", ["lamp"]), ("lamp", ["lamp"]),
     ("lam.on", []), ("robots", []), ("", []), ("a b/%2F", []), ("x" * 300, [])],
)  # fmt: skip
def test_services_of_a_path_are_those_that_its_first_steps_name(
    path: str, found: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    for name in ("robots%2Fr1", "robots%2Fr1%2Farm", "lamp", "lampion"):
        (tmp_path / f"{name}.ps").touch()
    assert places.services_of(path) == found


def test_folders_above_are_for_this_user_alone_whatever_the_umask(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir(mode=0o755)
    before = os.umask(0)
    try:
        places.make_private(str(tmp_path / "there/state/rtkit"))
    finally:
        os.umask(before)
    modes = [(tmp_path / each).stat().st_mode & 0o777 for each in ("there", "there/state")]
    assert modes == [0o755, 0o700]
