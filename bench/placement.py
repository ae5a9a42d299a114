"""Tells where measurements run: the machine, its load; and keeps processes on processors."""

from __future__ import annotations

import json
import os
import platform
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

_GOVERNOR = Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")


def machine() -> str:
    """Return processors, kernel and interpreter of this machine, in one line."""
    cpu = re.search(r"^model name\s*: (.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    return (
        f"{os.cpu_count()} processors ({cpu[1] if cpu else platform.machine()}), Linux"
        f" {platform.release()}, Python {platform.python_version()}"
    )


def governor() -> str | None:
    """Return what sets the frequency of the processors; None where the kernel does not tell."""
    try:
        return _GOVERNOR.read_text(encoding="ascii").strip()
    except OSError:
        return None


def as_json(load: float) -> str:
    """Return a line of JSON that tells what the rows after it were measured on."""
    return json.dumps(
        {
            "schema": "rtkit.bench/1",
            "machine": machine(),
            "processors_allowed": sorted(os.sched_getaffinity(0)),
            "governor": governor(),
            "load_before": float(f"{load:.3g}"),
        }
    )


def pin(pid: int, to: int) -> None:
    """Keep all threads that a process has on one processor, and those that they start."""
    for task in Path(f"/proc/{pid}/task").iterdir():
        os.sched_setaffinity(int(task.name), {to})


class Placed(NamedTuple):
    """Processors that both ends of a pair are kept on; so it is the same for rtkit and floor.

    Where the kernel places two processes that take turns makes a round trip four times as long, and
    not for both of a pair alike.
    """

    words: str
    client: frozenset[int]
    server: frozenset[int]


def placements() -> list[Placed]:
    """Return both ends on one processor, and on two where there are as many."""
    first, *others = sorted(os.sched_getaffinity(0))
    one = Placed("on one processor", frozenset({first}), frozenset({first}))
    two = [Placed("on two processors", frozenset({first}), frozenset({each})) for each in others]
    return [one, *two[:1]]


@contextmanager
def kept_on(processors: Iterable[int]) -> Iterator[None]:
    """Keep this thread, and what it starts, on these processors."""
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, processors)
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)
