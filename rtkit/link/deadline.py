"""Deadlines of requests: carry the time-out of a client to the process that serves it.

Processes of one host share a monotonic clock, as long as the machine runs: there a deadline holds
also for a request that lay in a queue, or before a process that was stopped. A process elsewhere
counts from the moment in which the request arrives.

Over zenoh it goes as bytes: there to write and read it as text would take as long as all else that
a service does for a request.

See decision 45.
"""

from __future__ import annotations

import math
import struct
from functools import cache
from time import monotonic

_PARAMETER = "deadline="
_FORM = struct.Struct("<16sdd")
"""Which run of which machine, when the request is given up by its clock, and after how long [s]."""


def deadline_to_text(timeout_s: float) -> str:
    """Return what goes with a request that is given up after `timeout_s` [s]."""
    return f"{boot_id()} {monotonic() + timeout_s:.6f} {timeout_s:g}"


def deadline_at(until: float) -> str:
    """Return what goes with a request that is given up at a moment, by the monotonic clock [s]."""
    return deadline_to_text(until - monotonic())


def with_deadline(target: str, until: float) -> str:
    """Return a target with its deadline as a parameter; infinity needs none."""
    if until == math.inf:
        return target
    mark = "&" if "?" in target else "?"
    return f"{target}{mark}{_PARAMETER}{deadline_at(until).replace(' ', '_')}"


def split_deadline(target: str) -> tuple[str, float]:
    """Return a target as it was before `with_deadline`, and the deadline."""
    if _PARAMETER not in target:
        return target, math.inf
    name, _, tail = target.partition("?")
    given = tail.split("&")
    found = [each for each in given if each.startswith(_PARAMETER)]
    kept = "&".join(each for each in given if each not in found)
    untils = (deadline_from_text(each[len(_PARAMETER) :].replace("_", " ")) for each in found)
    return (f"{name}?{kept}" if kept else name), min(untils, default=math.inf)


def deadline_from_text(text: str) -> float:
    """Return when a request is given up, by the monotonic clock here [s]; infinity if unknown."""
    try:
        boot, until, timeout = text.split()
        return float(until) if boot == boot_id() else monotonic() + float(timeout)
    except ValueError:  # of another version, which may say it in another way
        return math.inf


def deadline_to_bytes(timeout_s: float) -> bytes:
    """Return what goes with a request that is given up after `timeout_s` [s], in few bytes."""
    return _FORM.pack(_boot(), monotonic() + timeout_s, timeout_s)


def deadline_from_bytes(data: bytes) -> float:
    """Return when a request is given up, by the monotonic clock here [s]; infinity if unknown."""
    if len(data) != _FORM.size:  # of another version, which may say it in another way
        return math.inf
    until: float
    timeout: float
    boot, until, timeout = _FORM.unpack(data)
    return until if boot == _boot() else monotonic() + timeout


@cache
def boot_id() -> str:
    """Return which run of this machine it is."""
    with open("/proc/sys/kernel/random/boot_id", "rb") as file:
        return file.read().decode().strip()


@cache
def _boot() -> bytes:
    return bytes.fromhex(boot_id().replace("-", ""))
