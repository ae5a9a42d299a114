"""Compares the threads and descriptors of a process before and after."""

from __future__ import annotations

import os
import re
import time
from collections import Counter
from pathlib import Path

_PATIENCE_S = 20.0
_NUMBER = re.compile(r"\[?\d+\]?")


def held(pid: int) -> Counter[str]:
    """Return how much a process holds, by kind: threads, and descriptors by what they lead to."""
    found: Counter[str] = Counter()
    for entry in Path(f"/proc/{pid}/fd").iterdir():
        try:
            found[_NUMBER.sub("N", os.readlink(entry))] += 1
        except FileNotFoundError:  # closed meanwhile
            continue
    found["threads"] = len(list(Path(f"/proc/{pid}/task").iterdir()))
    return found


def grown(pid: int, before: Counter[str]) -> Counter[str]:
    """Return what a process holds more than before, when it has had time to let go of it."""
    deadline = time.monotonic() + _PATIENCE_S
    while (more := held(pid) - before) and time.monotonic() < deadline:
        time.sleep(0.02)
    return more
