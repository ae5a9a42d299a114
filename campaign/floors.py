"""What the same machine needs for the least of it, measured beside the system at work."""

from __future__ import annotations

import os
import select
import statistics
import sys
import time
from collections.abc import Callable
from typing import NamedTuple

import rtkit
from bench.harness import folders

_ROUNDS = 5
_HELLO = "import os, time; os.write({}, b'x'); time.sleep(60)"


class Floor(NamedTuple):
    """The median of what is measured [s], and what that is."""

    seconds: float
    what: str


def floors() -> tuple[Floor, Floor]:
    """Return floors of an end of a process, and of an end of a manager."""
    process = "a bare Python process is killed, waited for, and another one starts"
    manager = "a manager that finds nothing starts, until it has answered"
    return Floor(_median(_process_s), process), Floor(_median(_manager_s), manager)


def _median(measure: Callable[[], float]) -> float:
    return statistics.median(measure() for _ in range(_ROUNDS))


def _process_s() -> float:
    first = _started()
    began = time.monotonic()
    _end(first)
    second = _started()
    took_s = time.monotonic() - began
    _end(second)
    return took_s


def _started() -> int:
    """Start a Python process and wait until it says so; return its pid."""
    reading, writing = os.pipe()
    os.set_inheritable(writing, True)
    pid = os.posix_spawn(sys.executable, [sys.executable, "-c", _HELLO.format(writing)], os.environ)
    os.close(writing)
    os.read(reading, 1)
    os.close(reading)
    return pid


def _end(pid: int) -> None:
    descriptor = os.pidfd_open(pid)
    os.kill(pid, 9)
    select.select([descriptor], [], [])
    os.close(descriptor)
    os.waitpid(pid, 0)


def _manager_s() -> float:
    kept = {name: value for name, value in os.environ.items() if name.startswith("RTKIT_")}
    try:
        with folders():
            began = time.monotonic()
            with rtkit.connect(start=True) as tree:
                took_s = time.monotonic() - began
                tree.stop_manager()
            return took_s
    finally:
        os.environ.update(kept)
