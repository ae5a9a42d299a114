"""Ends processes that a killed manager left running, found by files or by their command line.

Unregistered forks hang before they reported anything, and their zygote is gone. Every other process
is known by a file, a connection, or its parent. These are known by their command line, which is
that of the zygote, and by a session whose leader has ended.
"""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, suppress

from rtkit.container.orphans import end_sessions
from rtkit.errors import Refused
from rtkit.link import places, running, unix
from rtkit.link.processes import ProcessWatch
from rtkit.manager.claim import remove_stale, take_lock
from rtkit.manager.predecessor.crashes import unseen_crashes
from rtkit.manager.predecessor.descendants import end_descendants
from rtkit.manager.predecessor.unreported import checkpoints_of_the_dead, is_slave, living_slaves

TERM_S = 7.0
"""Grace between TERM and KILL, in which components finalise [s]."""

_KILL_S = 5.0
_ZYGOTE_S = 1.0


def end_remains(name: str, term_s: float = TERM_S) -> int:
    """End the slaves of a manager of that name which does not run; return how many there were.

    Raises:
        Refused: It runs.
    """
    with ExitStack() as stack:
        take_lock(name, stack)
        crashes = unseen_crashes(name, checkpoints_of_the_dead(name, living_slaves(name)))
        slaves, zygotes = dict(_slaves(name, stack)), dict(_zygotes(name, stack))
        for slave in slaves.values():
            slave.send(signal.SIGTERM)
            slave.send(signal.SIGCONT)
        _kill(slaves, term_s)
        _kill(zygotes, _ZYGOTE_S)  # it ends with its last child
        end_sessions(slaves.keys(), is_heir=False)
        lost = end_lost(name)
        end_descendants(name)
        for crash in crashes:
            crash.log(name)
        remove_stale(name, ())
    return len(slaves) + len(lost)


def _slaves(name: str, stack: ExitStack) -> Iterator[tuple[int, ProcessWatch]]:
    """Yield each slave that runs, by pid."""
    for pid in living_slaves(name):
        with suppress(OSError):
            process = stack.enter_context(ProcessWatch(pid))
            if is_slave(name, pid):  # still, and so it is the one that is watched
                yield pid, process


def _zygotes(name: str, stack: ExitStack) -> Iterator[tuple[int, ProcessWatch]]:
    """Yield each process that forked them, by pid: it listens for the next manager."""
    for path in running.traces(name, "zygote").values():
        with suppress(OSError), unix.connect(path) as connection:
            pid = unix.pid_of(connection)
            yield pid, stack.enter_context(ProcessWatch(pid))


def _kill(processes: Mapping[int, ProcessWatch], grace_s: float) -> None:
    """Kill those of these processes that do not end in time.

    Raises:
        Refused: Some do not end even then.
    """
    left = _living(processes, grace_s)
    for process in left.values():
        process.send(signal.SIGKILL)
    left = _living(left, _KILL_S)
    if left:
        raise Refused(f"processes that do not end even when killed: {', '.join(map(str, left))}")


def _living(processes: Mapping[int, ProcessWatch], patience_s: float) -> dict[int, ProcessWatch]:
    """Wait for processes to end; return those that do not in time."""
    deadline = time.monotonic() + patience_s
    return {
        pid: process
        for pid, process in processes.items()
        if not process.await_end(max(0.0, deadline - time.monotonic()))
    }


_ZYGOTE = "rtkit.manager.slaves.zygote"
"""The module that a zygote runs, with two arguments: a descriptor, and its settings."""


def end_lost(manager: str) -> list[int]:
    """Kill those of a manager of that name; return their pids."""
    ended, pattern = [], places.zygote_pattern(manager)
    for pid in _lost(manager, pattern):
        with suppress(ProcessLookupError), ProcessWatch(pid) as process:
            if pattern == _pattern(pid):  # still, and so it is the one that is watched
                process.send(signal.SIGKILL)
                ended.append(pid)
    return ended


def _lost(manager: str, pattern: str) -> Iterator[int]:
    for entry in os.listdir("/proc"):
        if entry.isdigit() and _pattern(entry) == pattern:
            pid = int(entry)
            # One that hangs later has its heartbeats, and is found by them.
            if _has_lost_its_leader(pid, pattern) and not is_slave(manager, pid):
                yield pid


def _pattern(pid: int | str) -> str:
    """Return where the zygote listens whose command line a process has; empty for others."""
    try:
        with open(f"/proc/{pid}/cmdline", "rb", buffering=0) as file:
            words = file.read().split(b"\0")
    except OSError:
        return ""
    if _ZYGOTE.encode() not in words:
        return ""
    try:
        settings = json.loads(words[words.index(_ZYGOTE.encode()) + 2])
    except (ValueError, IndexError):
        return ""
    return str(settings.get("zygote", "")) if isinstance(settings, dict) else ""


def _has_lost_its_leader(pid: int, pattern: str) -> bool:
    try:
        leader = os.getsid(pid)
    except ProcessLookupError:
        return False
    return leader != pid and _pattern(leader) != pattern
