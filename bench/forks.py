"""Measures the floor for slaves: forks of a process with the same modules and no session.

``python -m bench.forks`` reads a request a line and answers with a number: ``fork N`` the time
until so many children have reported [ms], ``memory N`` the memory that each of them has of its own
at rest [MiB, proportional], ``stop N`` the time it takes to end them with TERM [ms].
"""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import time

from bench.processes import pss_mib


class Forks:
    """The process that forks."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "bench.forks"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def ask(self, what: str, count: int) -> float:
        """Return the answer to one request."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{what} {count}\n")
        self._process.stdin.flush()
        return float(self._process.stdout.readline())

    def close(self) -> None:
        """End it."""
        self._process.communicate()


def main() -> None:
    """Serve until the input ends."""
    gc.freeze()
    for line in sys.stdin:
        what, count = line.split()
        print(_ANSWERS[what](int(count)), flush=True)


def _fork(count: int) -> float:
    begin = time.perf_counter()
    children = _children(count)
    elapsed_ms = (time.perf_counter() - begin) * 1e3
    _end(children)
    return elapsed_ms


def _memory(count: int) -> float:
    children = _children(count)
    mib = pss_mib(children)
    _end(children)
    return mib


def _stop(count: int) -> float:
    children = _children(count)
    begin = time.perf_counter()
    _end(children)
    return (time.perf_counter() - begin) * 1e3


_ANSWERS = {"fork": _fork, "memory": _memory, "stop": _stop}


def _children(count: int) -> list[int]:
    """Return so many children that have been heard, and rest."""
    reading, writing = os.pipe()
    children = [_child(writing) for _ in range(count)]
    heard = 0
    while heard < count:
        heard += len(os.read(reading, count))
    os.close(reading)
    os.close(writing)
    return children


def _end(children: list[int]) -> None:
    for pid in children:
        os.kill(pid, signal.SIGTERM)
    for pid in children:
        os.waitpid(pid, 0)


def _child(writing: int) -> int:
    pid = os.fork()
    if pid:
        return pid
    os.setsid()
    os.write(writing, b"x")
    while True:
        signal.pause()


if __name__ == "__main__":
    main()
