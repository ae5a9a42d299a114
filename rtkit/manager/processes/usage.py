"""Reads the usage of a process from the kernel: processor time and memory."""

from __future__ import annotations

import os
from typing import NamedTuple

_TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")
_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


class Usage(NamedTuple):
    """Processor time of all threads [s], and memory that is resident [bytes]."""

    cpu_s: float
    memory_bytes: int


def usage(pid: int) -> Usage | None:
    """Return what a process uses; None when it is gone.

    Source: proc(5), fields 14, 15 and 24 of ``/proc/PID/stat``.
    """
    try:
        with open(f"/proc/{pid}/stat", "rb", buffering=0) as file:
            fields = file.read().rpartition(b")")[2].split()
    except OSError:
        return None
    return Usage((int(fields[11]) + int(fields[12])) * _TICK_S, int(fields[21]) * _PAGE_BYTES)
