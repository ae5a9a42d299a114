"""Reads the kernel's data on processes: memory, processor time, existence."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress

_PSS = re.compile(r"^Pss: +(\d+) kB", re.MULTILINE)


def pss_mib(pids: Iterable[int]) -> float:
    """Return what each process has in memory, shared pages divided among those who share them.

    The mean of all, proportional set size [MiB].
    """
    sizes = []
    for pid in pids:
        with open(f"/proc/{pid}/smaps_rollup", encoding="ascii") as file:
            match = _PSS.search(file.read())
        assert match is not None
        sizes.append(int(match[1]) / 1024)
    return sum(sizes) / len(sizes)


def processor_s(pids: Iterable[int]) -> float:
    """Return the processor time that all threads of processes have had together [s].

    From the scheduler, which counts nanoseconds: an idle process uses less than a tick.
    """
    total_ns = 0
    for pid in pids:
        for thread in os.listdir(f"/proc/{pid}/task"):
            with open(f"/proc/{pid}/task/{thread}/schedstat", encoding="ascii") as file:
                total_ns += int(file.read().split()[0])
    return total_ns / 1e9


@contextmanager
def own_group(name: str) -> Iterator[Callable[[], float]]:
    """Be in a control group of its own; yield what returns the processor time of all in it [s].

    So whoever else is at work on the machine does not count.
    """
    old = os.path.isdir("/sys/fs/cgroup/cpuacct")
    top = "/sys/fs/cgroup/cpuacct" if old else "/sys/fs/cgroup"
    folder = os.path.join(top, f"rtbench{os.getpid()}{name}")
    os.mkdir(folder)

    def move(to: str) -> None:
        with open(os.path.join(to, "cgroup.procs"), "w", encoding="ascii") as file:
            file.write(str(os.getpid()))

    def spent_s() -> float:
        counter = "cpuacct.usage" if old else "cpu.stat"
        with open(os.path.join(folder, counter), encoding="ascii") as file:
            text = file.read()
        return int(text) / 1e9 if old else int(text.split()[1]) / 1e6

    move(folder)
    try:
        yield spent_s
    finally:
        move(top)
        with suppress(OSError):  # whoever has not ended yet is in it
            os.rmdir(folder)


def parent(pid: int) -> int:
    """Return the parent of a process."""
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
        return int(file.read().rpartition(")")[2].split()[1])


def children(pid: int) -> list[int]:
    """Return the processes whose parent is another."""
    found = []
    for name in filter(str.isdecimal, os.listdir("/proc")):
        with suppress(OSError):
            if parent(int(name)) == pid:
                found.append(int(name))
    return found


def living(pids: Iterable[int]) -> list[int]:
    """Return those that are there and not just waited for."""
    found = []
    for pid in pids:
        try:
            with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
                if file.read().rpartition(")")[2].split()[0] != "Z":
                    found.append(pid)
        except (FileNotFoundError, ProcessLookupError):
            continue
    return found
