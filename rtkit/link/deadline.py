"""Deadlines of requests: how the time-out of a client travels to the process that serves it.

Processes of one host share a monotonic clock, as long as the machine runs: there a deadline holds
also for a request that lay in a queue, or before a process that was stopped. A process elsewhere
counts from the moment in which the request arrives.
"""

from __future__ import annotations

import math
from functools import cache
from time import monotonic


def deadline_to_text(timeout_s: float) -> str:
    """Return what goes with a request that is given up after `timeout_s` [s]."""
    return f"{boot_id()} {monotonic() + timeout_s:.6f} {timeout_s:g}"


def deadline_from_text(text: str) -> float:
    """Return when a request is given up, by the monotonic clock here [s]; infinity if unknown."""
    try:
        boot, until, timeout = text.split()
        return float(until) if boot == boot_id() else monotonic() + float(timeout)
    except ValueError:  # of another version, which may say it in another way
        return math.inf


@cache
def boot_id() -> str:
    """Return which run of this machine it is."""
    with open("/proc/sys/kernel/random/boot_id", encoding="ascii") as file:
        return file.read().strip()
