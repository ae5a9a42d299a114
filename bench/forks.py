"""A floor for slaves: forks when asked, from a process that holds the same modules and no session.

Reads a number of children a line and answers how long it took until all were heard [ms].
"""

from __future__ import annotations

import gc
import os
import sys
import time

from rtkit.manager.processes import slave  # noqa: F401 - what a zygote has in memory


def main() -> None:
    """Serve until the input ends."""
    gc.freeze()
    for line in sys.stdin:
        print(_fork(int(line)), flush=True)


def _fork(count: int) -> float:
    reading, writing = os.pipe()
    begin = time.perf_counter()
    children = [_child(writing) for _ in range(count)]
    heard = 0
    while heard < count:
        heard += len(os.read(reading, count))
    elapsed_ms = (time.perf_counter() - begin) * 1e3
    for pid in children:
        os.waitpid(pid, 0)
    os.close(reading)
    os.close(writing)
    return elapsed_ms


def _child(writing: int) -> int:
    pid = os.fork()
    if pid:
        return pid
    os.setsid()
    os.write(writing, b"x")
    os._exit(0)


if __name__ == "__main__":
    main()
