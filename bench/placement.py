"""Tells where measurements run: the machine, its load; and keeps processes on processors."""

from __future__ import annotations

import json
import os
import platform
import re
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


def pin(pid: int, to: int) -> None:
    """Keep all threads that a process has on one processor, and those that they start."""
    for task in Path(f"/proc/{pid}/task").iterdir():
        os.sched_setaffinity(int(task.name), {to})
