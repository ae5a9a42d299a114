"""Usage of a process, and of all that descends from it: processor time, memory, descriptors."""

from __future__ import annotations

import os
from contextlib import suppress
from typing import NamedTuple

from rtkit.container.orphans import family
from rtkit.link.processes import stat_of

_TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")
_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


class Usage(NamedTuple):
    """Processor time of all threads [s], and memory that is resident [bytes]."""

    cpu_s: float
    memory_bytes: int


class Used(NamedTuple):
    """Usage of a tree of processes.

    Attributes:
        pids: Of its processes; none when it is gone.
        memory: Resident memory; what several share counts in each [bytes].
        largest: The most that one of them has resident [bytes].
        cpu_s: Processor time, of those too that ended and were waited for [s].
    """

    pids: tuple[int, ...] = ()
    memory: int = 0
    largest: int = 0
    cpu_s: float = 0.0


def usage(pid: int) -> Usage | None:
    """Return what a process uses; None when it is gone.

    Source: proc(5), fields 14, 15 and 24 of ``/proc/PID/stat``.
    """
    fields = stat_of(pid)
    if not fields:
        return None
    return Usage((int(fields[11]) + int(fields[12])) * _TICK_S, int(fields[21]) * _PAGE_BYTES)


def tree_usage(pid: int) -> Used:
    """Return what a process uses with all that descends from it.

    Source: proc(5), fields 14 to 17 and 24 of ``/proc/PID/stat``.
    """
    found = {each: fields for each in (pid, *family(pid)) if (fields := stat_of(each))}
    if pid not in found:
        return Used()
    memory = [int(fields[21]) * _PAGE_BYTES for fields in found.values()]
    ticks = sum(sum(map(int, fields[11:15])) for fields in found.values())
    return Used(tuple(found), sum(memory), max(memory), ticks * _TICK_S)


def descriptors(pids: tuple[int, ...]) -> int:
    """Return how many descriptors that one of these processes has which has most."""
    return max((_descriptors(pid) for pid in pids), default=0)


def proportional_memory(pids: tuple[int, ...]) -> int:
    """Return the memory of processes; what they share with others counts in parts [bytes].

    It takes milliseconds for each. Source: proc(5), ``/proc/PID/smaps_rollup``.
    """
    return sum(map(_proportional, pids))


def data_bytes(pid: int) -> int:
    """Return how large what a process may write to itself is; 0 when it is gone [bytes]."""
    with suppress(OSError), open(f"/proc/{pid}/statm", "rb") as file:
        return int(file.read().split()[5]) * _PAGE_BYTES
    return 0


def _descriptors(pid: int) -> int:
    path = f"/proc/{pid}/fd"
    with suppress(OSError):
        # Since Linux 6.2 the folder tells its size; before, it has to be read.
        return os.stat(path).st_size or len(os.listdir(path))
    return 0


def _proportional(pid: int) -> int:
    with suppress(OSError), open(f"/proc/{pid}/smaps_rollup", "rb") as file:
        for line in file:
            if line.startswith(b"Pss:"):
                return int(line.split()[1]) * 1024
    return 0
