"""Stores values that are at hand, as floors of a recording: by the mcap package, and bare.

``python -m bench.writers package|bare FILE`` answers each line ``COUNT SIZE`` with the time and the
processor time that so many values took [ms]. It is a process of its own, as a recorder is.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple, TypeAlias

PACKAGE_IS = "the writer of the mcap package alone, values at hand, to the same disk"
BARE_IS = "write() of the same octets from memory, to the same disk"
_KINDS = 16
"""How many different values there are, as many as lie in shared memory at most."""
_KEPT = {"MALLOC_MMAP_THRESHOLD_": str(1 << 27), "MALLOC_TRIM_THRESHOLD_": str(1 << 30)}
"""Settings by which the C library keeps memory that was freed.

Without them the package takes two or three times as long at one time and not at another, as each of
its copies gets new pages from the kernel.
"""

Values: TypeAlias = list[memoryview]


class Cost(NamedTuple):
    """Time and processor time [ms]."""

    elapsed_ms: float
    spent_ms: float


@contextmanager
def writer(kind: str, path: str) -> Iterator[Callable[[int, int], Cost]]:
    """Run a writer of a kind; yield what measures so many values of so many bytes."""
    words = [sys.executable, "-m", "bench.writers", kind, path]
    pipe, environment = subprocess.PIPE, {**os.environ, **_KEPT}
    process = subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True, env=environment)
    assert process.stdin is not None
    assert process.stdout is not None
    asked, answers = process.stdin, process.stdout

    def measure(count: int, size: int) -> Cost:
        asked.write(f"{count} {size}\n")
        asked.flush()
        return Cost(*map(float, answers.readline().split()))

    try:
        yield measure
    finally:
        process.communicate()


def _by_the_package(path: str, values: Values, count: int) -> None:
    """Store values as the mcap package does, in chunks of the size of those of rtlog."""
    from mcap.writer import CompressionType, Writer

    with open(path, "xb") as file:
        mcap = Writer(file, chunk_size=512 << 10, compression=CompressionType.NONE)
        mcap.start()
        channel = mcap.register_channel("images", "cdr", 0)
        for number in range(count):
            value: bytes = values[number % _KINDS]  # type: ignore[assignment]
            mcap.add_message(channel, time.time_ns(), value, time.time_ns(), number)
        mcap.finish()  # type: ignore[no-untyped-call]


def _bare(path: str, values: Values, count: int) -> None:
    """Store the octets alone, one behind the other."""
    with open(path, "xb", buffering=0) as file:
        for number in range(count):
            file.write(values[number % _KINDS])


def main(kind: str, path: str) -> None:
    """Store values until the input ends."""
    store = {"package": _by_the_package, "bare": _bare}[kind]
    for line in sys.stdin:
        count, size = map(int, line.split())
        values = [memoryview(os.urandom(size)) for _ in range(_KINDS)]
        begin_s, spent_s = time.perf_counter(), time.process_time()
        store(path, values, count)
        elapsed_s, spent_s = time.perf_counter() - begin_s, time.process_time() - spent_s
        os.unlink(path)
        print(elapsed_s * 1e3, spent_s * 1e3, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
