"""Tells where measurements run: the machine, its load, the processors of both ends."""

from __future__ import annotations

import json
import os
import platform
import re
from collections.abc import Iterable
from pathlib import Path

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


def processor(pid: int) -> int:
    """Return the processor on which the first thread of a process ran last."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return int(fields[36])  # the 39th of proc(5); the name and what is before it are cut off


def of_ends(seen: Iterable[tuple[int, int]]) -> str:
    """Return how often two ends were seen on one processor, and on two."""
    alike = [one == other for one, other in seen]
    return f"ends on one processor in {sum(alike)} of {len(alike)}, on two in the others"
