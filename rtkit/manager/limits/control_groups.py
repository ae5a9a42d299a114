"""Control groups: what this host or the Linux container has; limited slaves are put into them.

Slaves are where version 2 of the kernel's groups lets this user. They only hold what runs away
between two looks (see `rtkit.manager.limits.limiter`): most containers and log-ins let nobody write
them, and what a limit means is to be the same everywhere.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from math import inf

from rtkit.container.orphans import family
from rtkit.deployment.limits import Capacity, SlaveLimits

_ROOT = "/sys/fs/cgroup"
_WANTED = ("memory", "pids", "cpu")
_OURS = "rtkit-"
_MANAGER = f"{_OURS}manager"
_PERIOD_US = 100_000
_MORE = 1.05
"""By how much more than its share a slave may use, so that a look sees it use more."""
_THREADS = 64
"""How many threads each process is taken to have: the kernel counts those."""


class ControlGroups:
    """Puts slaves into control groups below `parent`."""

    def __init__(self, parent: str) -> None:
        self._parent = parent
        self._folders: dict[int, str] = {}

    def limit(self, pid: int, limits: SlaveLimits) -> None:
        """Have a process, and what it starts from now on, kept within limits.

        Raises:
            OSError: The kernel refuses.
        """
        folder = self._folders.get(pid) or self._make(pid)
        share = limits.processor * _MORE
        values = {
            "memory.max": str(limits.memory or "max"),
            "memory.swap.max": "0" if limits.memory else "max",
            "pids.max": str(limits.processes * _THREADS or "max"),
            "cpu.max": f"{max(1000, int(share * _PERIOD_US)) if share else 'max'} {_PERIOD_US}",
        }
        _write_all(folder, values)
        _write(f"{folder}/cgroup.procs", str(pid))

    def was_out_of_memory(self, pid: int) -> bool:
        """Return whether the kernel killed anything in a process's group for want of memory."""
        folder = self._folders.get(pid, "")
        lines = _read(f"{folder}/memory.events").splitlines() if folder else []
        return any(line.startswith("oom_kill ") and line.split()[1] != "0" for line in lines)

    def forget(self, pid: int) -> None:
        """Remove the group of a process that ended; one that is not empty yet goes later."""
        if self._folders.pop(pid, None):
            self.tidy()

    def tidy(self) -> None:
        """Remove groups in which nothing runs: those of an earlier manager, too."""
        with suppress(FileNotFoundError):  # somebody removed it all
            for entry in os.listdir(self._parent):
                if entry.startswith(_OURS) and entry != _MANAGER:
                    with suppress(OSError):  # something runs in it
                        os.rmdir(f"{self._parent}/{entry}")

    def _make(self, pid: int) -> str:
        name = f"{_OURS}{pid}"
        folder = f"{self._parent}/{name}"
        with suppress(FileExistsError):
            os.mkdir(folder)
        self._folders[pid] = folder
        return folder


def control_groups(root: str = _ROOT, proc: str = "/proc") -> ControlGroups | None:
    """Return where control groups for slaves can be made; None where they cannot.

    A group with processes in it has no limited ones below it: where all of them are this
    manager's, they go into one more. A service has that from systemd, or does without: systemd
    starts no manager again in a group above those of slaves that outlived the last one.
    """
    own = _own_group(_read(f"{proc}/self/cgroup"))
    is_service = os.environ.get("SYSTEMD_EXEC_PID") == str(os.getpid())
    if own is None or (is_service and not own.endswith(f"/{_MANAGER}")):
        return None
    parent = f"{root}{own}".rstrip("/").removesuffix(f"/{_MANAGER}")
    had = _read(f"{parent}/cgroup.controllers").split()
    controllers = [each for each in _WANTED if each in had]
    if not controllers or not os.access(f"{parent}/cgroup.procs", os.W_OK):
        return None
    enabled = _read(f"{parent}/cgroup.subtree_control").split()
    missing = " ".join(f"+{each}" for each in controllers if each not in enabled)
    try:
        if missing:
            _enable(parent, missing)
        groups = ControlGroups(parent)
        groups.tidy()
    except OSError:
        return None
    return groups


def _enable(parent: str, missing: str) -> None:
    control = f"{parent}/cgroup.subtree_control"
    try:
        _write(control, missing)
    except OSError:
        pids = set(map(int, _read(f"{parent}/cgroup.procs").split()))
        ours = {os.getpid(), *family(os.getpid())}
        if not pids <= ours:
            raise
        _move(parent, pids)
        _write(control, missing)


def _move(parent: str, pids: Collection[int]) -> None:
    folder = f"{parent}/{_MANAGER}"
    with suppress(FileExistsError):
        os.mkdir(folder)
    for pid in pids:
        with suppress(ProcessLookupError):
            _write(f"{folder}/cgroup.procs", str(pid))


def _own_group(text: str) -> str | None:
    """Return the path of the group of version 2; None without one."""
    return next((line[3:] for line in text.splitlines() if line.startswith("0::/")), None)


def _write_all(folder: str, values: Mapping[str, str]) -> None:
    for name, text in values.items():
        if os.path.exists(f"{folder}/{name}"):  # not every kernel has each controller
            _write(f"{folder}/{name}", text)


def _write(path: str, text: str) -> None:
    descriptor = os.open(path, os.O_WRONLY)
    try:
        os.write(descriptor, text.encode())
    finally:
        os.close(descriptor)


def _read(path: str) -> str:
    with suppress(OSError), open(path, encoding="utf-8") as file:
        return file.read()
    return ""


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
            quota, period = _read(f"{folder}/cpu.max").split() or ("", "")
            processors = min(processors, _share(quota, period))
            quotas = (_read(f"{folder}/cpu.cfs_{each}_us").split() for each in ("quota", "period"))
            processors = min(processors, _share(*(words[0] if words else "" for words in quotas)))
    return Capacity(memory, processors)


def free_memory(root: str = _ROOT, groups: str = _GROUPS, meminfo: str = _MEMINFO) -> float:
    """Return the memory that is free here [bytes]: the least of the machine and its groups.

    Memory that holds files which could be read again counts as free, as in ``MemAvailable``.
    """
    free = _total(meminfo, "MemAvailable")
    for controllers, path in _own(groups):
        for folder in _upwards(root, controllers, path):
            for limit, usage in (("max", "current"), ("limit_in_bytes", "usage_in_bytes")):
                stat = dict(line.split(" ", 1) for line in _lines(f"{folder}/memory.stat"))
                files = float(stat.get("inactive_file") or stat.get("total_inactive_file") or 0)
                used = _number(f"{folder}/memory.{usage}")
                if used < inf:
                    free = min(free, _number(f"{folder}/memory.{limit}") - used + files)
    return max(0.0, free)


def _lines(path: str) -> list[str]:
    return [line for line in _read(path).splitlines() if " " in line]


def _total(path: str, field: str = "MemTotal") -> float:
    with open(path, encoding="ascii") as file:
        fields = dict(line.split(":", 1) for line in file if ":" in line)
    return float(fields[field].split()[0]) * 1024


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
    words = _read(path).split()
    return float(words[0]) if words and words[0].isdigit() else inf


def _share(quota: str, period: str) -> float:
    if not (quota.isdigit() and period.isdigit()) or not int(period):
        return inf
    return int(quota) / int(period)
