"""Reads the kernel's data on processes: memory, processor time, existence."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable

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


def parent(pid: int) -> int:
    """Return the parent of a process."""
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
        return int(file.read().rpartition(")")[2].split()[1])


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
