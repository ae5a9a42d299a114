"""The list of what a process has started, and who is ended by it."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from rtkit.container.orphans import began_at, family
from rtkit.link.deadline import boot_id
from rtkit.manager.child_process import MARK, unmarked
from rtkit.manager.predecessor.descendants import Descendants, end_descendants

DEAD = 999_999_999


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "r").mkdir(mode=0o700)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path / "r"))
    return tmp_path / "r"


@pytest.fixture
def sleeper() -> Iterator[subprocess.Popen[bytes]]:
    with subprocess.Popen(["sleep", "1000"], start_new_session=True) as process:
        yield process
        process.kill()


def put(folder: Path, began: dict[int, int], boot: str = "") -> None:
    text = json.dumps({"boot": boot or boot_id(), "began": began})
    (folder / f"m.{DEAD}.family").write_text(text)


def test_the_list_is_of_all_but_zygotes_and_slaves(
    folder: Path, sleeper: subprocess.Popen[bytes]
) -> None:
    listed = Descendants("m")
    children = {sleeper.pid, *family(os.getpid())}  # of other tests, too
    listed.note(children)
    assert not list(folder.iterdir())
    listed.note(children - {sleeper.pid})
    (file,) = folder.iterdir()
    assert file.name == f"m.{os.getpid()}.family"
    began = json.loads(file.read_text())["began"]
    assert began[str(sleeper.pid)] == began_at(sleeper.pid)


def test_who_is_on_the_list_is_ended(folder: Path, sleeper: subprocess.Popen[bytes]) -> None:
    put(folder, {sleeper.pid: began_at(sleeper.pid), DEAD: 1})
    assert end_descendants("m") == [sleeper.pid]
    assert sleeper.wait(10.0) == -9


@pytest.mark.parametrize(("later", "boot"), [(1, ""), (0, "another")])
def test_a_stranger_with_a_pid_of_the_list_is_not(
    folder: Path, sleeper: subprocess.Popen[bytes], later: int, boot: str
) -> None:
    put(folder, {sleeper.pid: began_at(sleeper.pid) + later}, boot)
    assert end_descendants("m") == []
    assert sleeper.poll() is None


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"boot": 1, "began": []}', "\xff"])
def test_a_damaged_list_ends_nobody(folder: Path, text: str) -> None:
    (folder / f"m.{DEAD}.family").write_text(text, "latin-1")
    assert end_descendants("m") == []


@pytest.mark.parametrize("is_dead", [True, False])
def test_the_mark_of_a_manager_that_has_ended_is_an_end(folder: Path, *, is_dead: bool) -> None:
    (folder / f"m.{DEAD}.beats").touch()
    owner = f"{DEAD}:7" if is_dead else f"{os.getpid()}:{began_at(os.getpid())}"
    for lock, is_its_own in (("m.lock", True), ("n.lock", False)):
        environment = {**os.environ, MARK: f"{folder / lock}:{owner}"}
        with subprocess.Popen(["sleep", "1000"], env=environment) as process:
            expected = [process.pid] if is_dead and is_its_own else []
            assert end_descendants("m") == expected
            process.kill()


def test_what_is_to_outlive_the_manager_bears_no_mark() -> None:
    assert unmarked({MARK: "x", "HOME": "/"}) == {"HOME": "/"}
