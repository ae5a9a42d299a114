"""Control groups of slaves, on folders that stand for those of the kernel."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from rtkit.deployment.limits import NO_LIMITS, SlaveLimits
from rtkit.manager.limits.control_groups import ControlGroups, control_groups

FILES = ("cgroup.procs", "memory.max", "memory.swap.max", "pids.max", "cpu.max")
LIMITS = SlaveLimits(memory=1 << 20, processes=2, processor=0.5)


def group(folder: Path, *, enabled: str = "cpu memory pids") -> Path:
    folder.mkdir(parents=True)
    (folder / "cgroup.controllers").write_text("cpuset cpu io memory pids")
    (folder / "cgroup.subtree_control").write_text(enabled)
    (folder / "cgroup.procs").write_text("")
    return folder


@pytest.fixture
def system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine whose manager is in the group ``/a``; new groups have the files of a kernel's."""
    proc = tmp_path / "proc/self"
    proc.mkdir(parents=True)
    (proc / "cgroup").write_text("5:memory:/old\n0::/a\n")
    make = os.mkdir

    def mkdir(path: str, mode: int = 0o777) -> None:
        make(path, mode)
        for name in FILES:
            Path(path, name).write_text("")

    monkeypatch.setattr(os, "mkdir", mkdir)
    return tmp_path


def found(system: Path) -> ControlGroups | None:
    return control_groups(str(system / "fs"), str(system / "proc"))


def written(folder: Path) -> dict[str, str]:
    return {name: (folder / name).read_text() for name in FILES}


def test_a_service_has_groups_only_where_systemd_starts_it_beside_them(
    system: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = group(system / "fs/a")
    monkeypatch.setenv("SYSTEMD_EXEC_PID", str(os.getpid()))
    assert found(system) is None
    (system / "proc/self/cgroup").write_text("0::/a/rtkit-manager\n")
    assert found(system) is not None
    assert own.exists()


def test_a_limited_slave_has_a_group_of_its_own_until_it_ends(system: Path) -> None:
    own = group(system / "fs/a")
    groups = found(system)
    assert groups is not None
    groups.limit(42, LIMITS)
    assert written(own / "rtkit-42") == {
        "cgroup.procs": "42",
        "memory.max": "1048576",
        "memory.swap.max": "0",
        "pids.max": "128",
        "cpu.max": "52500 100000",
    }
    groups.limit(42, NO_LIMITS)
    assert (own / "rtkit-42/memory.max").read_text().startswith("max")
    for name in FILES:
        (own / "rtkit-42" / name).unlink()  # a kernel removes them with the folder
    groups.forget(42)
    assert not (own / "rtkit-42").exists()


def test_what_a_killed_manager_left_is_removed_by_the_next_one(system: Path) -> None:
    own = group(system / "fs/a")
    (own / "rtkit-7").mkdir()
    for name in FILES:
        (own / "rtkit-7" / name).unlink()
    (own / "other").mkdir()
    (own / "rtkit-8").mkdir()
    (own / "rtkit-8/cgroup.procs").write_text("8")  # runs
    found(system)
    assert sorted(each.name for each in own.iterdir() if each.is_dir()) == ["other", "rtkit-8"]


def test_that_the_kernel_ended_something_for_want_of_memory_is_seen(system: Path) -> None:
    own = group(system / "fs/a")
    groups = found(system)
    assert groups is not None
    groups.limit(42, LIMITS)
    events = own / "rtkit-42/memory.events"
    for text, was in (("oom 1\noom_kill 0\n", False), ("oom 1\noom_kill 2\n", True)):
        events.write_text(text)
        assert groups.was_out_of_memory(42) is was
    assert not groups.was_out_of_memory(43)


def test_controllers_are_enabled_where_they_are_not(system: Path) -> None:
    own = group(system / "fs/a", enabled="")
    assert found(system) is not None
    assert (own / "cgroup.subtree_control").read_text() == "+memory +pids +cpu"


@pytest.mark.parametrize("text", ["5:memory:/old\n", ""])
def test_without_version_2_there_are_none(system: Path, text: str) -> None:
    group(system / "fs/a")
    (system / "proc/self/cgroup").write_text(text)
    assert found(system) is None


def _writable() -> list[str]:
    """Return where the kernel's groups of version 2 are, if this user may make some."""
    mounts = [line.split() for line in Path("/proc/mounts").read_text().splitlines()]
    return [each[1] for each in mounts if each[2] == "cgroup2" and os.access(each[1], os.W_OK)]


@pytest.mark.skipif(not _writable(), reason="no control groups can be made here")
def test_the_kernel_takes_a_process_into_its_group_and_gives_the_group_back() -> None:
    groups = ControlGroups(_writable()[0])
    with subprocess.Popen(["sleep", "1000"]) as process:
        groups.limit(process.pid, SlaveLimits(memory=1 << 30, processes=4, processor=0.5))
        assert f"/rtkit-{process.pid}\n" in Path(f"/proc/{process.pid}/cgroup").read_text()
        process.kill()
    groups.forget(process.pid)
    assert not Path(_writable()[0], f"rtkit-{process.pid}").exists()


def test_without_controllers_there_are_none(system: Path) -> None:
    own = group(system / "fs/a")
    (own / "cgroup.controllers").write_text("hugetlb")
    assert found(system) is None
