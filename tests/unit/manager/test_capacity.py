"""What a host has, as the machine and its control groups say."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rtkit.manager.limits.control_groups import capacity

MIB = 1 << 20


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    (tmp_path / "meminfo").write_text("MemTotal:       4194304 kB\nMemFree: 1 kB\n")
    (tmp_path / "groups").write_text("")
    return tmp_path


def told(machine: Path) -> tuple[float, float]:
    memory, processors = capacity(
        str(machine / "fs"), str(machine / "groups"), str(machine / "meminfo")
    )
    return memory / MIB, processors


def put(machine: Path, group: str, **files: str) -> None:
    folder = machine / "fs" / group
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name.replace("__", ".")).write_text(text)


def test_without_groups_it_is_the_machine(machine: Path) -> None:
    assert told(machine) == (4096.0, float(len(os.sched_getaffinity(0))))


def test_version_2_limits_at_every_height(machine: Path) -> None:
    (machine / "groups").write_text("0::/a/b\n")
    put(machine, "a/b", memory__max="max\n", cpu__max="max 100000\n")
    put(machine, "a", memory__max=f"{512 * MIB}\n", cpu__max="50000 100000\n")
    put(machine, "", memory__max=f"{1024 * MIB}\n")
    assert told(machine) == (512.0, 0.5)


def test_version_1_limits(machine: Path) -> None:
    (machine / "groups").write_text("5:cpu,cpuacct:/c\n4:memory:/m\n3:cpuset:/\n1:name=x:/y\n")
    put(machine, "memory/m", memory__limit_in_bytes=f"{256 * MIB}\n")
    put(machine, "cpu,cpuacct/c", cpu__cfs_quota_us="25000\n", cpu__cfs_period_us="100000\n")
    put(machine, "cpu,cpuacct", cpu__cfs_quota_us="-1\n", cpu__cfs_period_us="100000\n")
    assert told(machine) == (256.0, 0.25)


def test_this_host_has_something() -> None:
    found = capacity()
    assert found.memory > 64 * MIB
    assert 0 < found.processors <= len(os.sched_getaffinity(0))
