"""Files of owned systems: the owner's process is there as long as there are any that count."""

from __future__ import annotations

import pytest

from rtkit.link import owned_files
from rtkit.manager import host_link_processes
from rtkit.manager.host_link_processes import HostLinkProcesses


@pytest.fixture
def begun(shell, tmp_path, monkeypatch):
    """What a manager begins, with folders of its own."""
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path / "state"))
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path / "run"))
    found: list[str] = []

    class Fake:
        def __init__(self, arguments, _ended, _closed=None):
            found.append(arguments[0])

        def hasten(self):
            found.append("hastened")

        def close(self):
            found.append("closed")

    monkeypatch.setattr(host_link_processes, "KeptProcess", Fake)
    return found


def test_the_owner_is_there_while_it_owns_something(shell, begun):
    links = HostLinkProcesses(shell.state)
    links.sync()
    assert begun == []
    path = owned_files.path_of("manager", "RTSystem:Me:S/x:1")
    owned_files.write(path, "{}")
    shell.state.kept.fences["A"] = ("5", "robot1/manager", "here/manager")
    links.sync()
    links.sync()
    assert begun == ["rtkit.api.owner_process", "hastened"]
    assert owned_files.remove(path)
    assert not owned_files.remove(path)
    links.sync()
    assert begun[2:] == ["closed"]


def test_files_of_a_manager_that_was_stopped_for_good_go(shell, begun):
    owned_files.write(owned_files.path_of("manager", "old"), "{}")
    owned_files.write(owned_files.path_of("m2", "other"), "{}")
    HostLinkProcesses(shell.state).sync()
    assert begun == []
    assert owned_files.of_manager("manager") == []
    assert len(owned_files.of_manager("m2")) == 1


def test_a_file_is_exchanged_only_while_it_is_the_one_that_was_read(begun):
    path = owned_files.path_of("manager", "S")
    owned_files.write(path, "old")
    assert owned_files.exchange(path, lambda text: text == "old", "new")
    assert not owned_files.exchange(path, lambda text: text == "old", "newer")
    assert owned_files.read(path) == "new"
    owned_files.remove(path)
    assert not owned_files.exchange(path, lambda text: text == "new", "newer")
    assert owned_files.read(path) == ""
