"""Reads how much memory and how many processors this host has, or the Linux container it is."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from math import inf

from rtkit.deployment.limits import Capacity

_ROOT = "/sys/fs/cgroup"
_GROUPS = "/proc/self/cgroup"
_MEMINFO = "/proc/meminfo"


def capacity(root: str = _ROOT, groups: str = _GROUPS, meminfo: str = _MEMINFO) -> Capacity:
    """Return what may be used here: the least of the machine and its control groups.

    Sources: proc(5), cgroups(7); ``memory.max`` and ``cpu.max`` of version 2 and their like of 1.
    """
    memory, processors = _total(meminfo), float(len(os.sched_getaffinity(0)))
    for controllers, path in _own(groups):
        for folder in _upwards(root, controllers, path):
            memory = min(memory, _number(f"{folder}/memory.max"))
            memory = min(memory, _number(f"{folder}/memory.limit_in_bytes"))
            quota, period = _words(f"{folder}/cpu.max") or ("", "")
            processors = min(processors, _share(quota, period))
            quotas = (_words(f"{folder}/cpu.cfs_{each}_us") for each in ("quota", "period"))
            processors = min(processors, _share(*(words[0] if words else "" for words in quotas)))
    return Capacity(memory, processors)


def _total(path: str) -> float:
    with open(path, encoding="ascii") as file:
        fields = dict(line.split(":", 1) for line in file if ":" in line)
    return float(fields["MemTotal"].split()[0]) * 1024


def _own(path: str) -> Iterator[tuple[str, str]]:
    """Yield controllers, none in version 2, and path of each control group of this process."""
    with suppress(OSError), open(path, encoding="utf-8") as file:
        for line in file:
            _, controllers, group = line.rstrip("\n").split(":", 2)
            if controllers in ("", "memory") or "cpu" in controllers.split(","):
                yield controllers, group


def _upwards(root: str, controllers: str, group: str) -> Iterator[str]:
    """Yield the folders of a control group and of those above it."""
    top = f"{root}/{controllers}" if controllers else root
    parts = [part for part in group.split("/") if part and part != ".."]
    for depth in range(len(parts), -1, -1):
        yield "/".join([top, *parts[:depth]])


def _number(path: str) -> float:
    words = _words(path)
    return float(words[0]) if words and words[0].isdigit() else inf


def _share(quota: str, period: str) -> float:
    if not (quota.isdigit() and period.isdigit()) or not int(period):
        return inf
    return int(quota) / int(period)


def _words(path: str) -> list[str]:
    with suppress(OSError), open(path, encoding="ascii") as file:
        return file.read().split()
    return []
