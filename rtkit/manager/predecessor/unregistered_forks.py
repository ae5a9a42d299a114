"""Ends unregistered forks: they hang before they reported anything, and their zygote is gone.

Every other process is known by a file, a connection, or its parent. These are known by their
command line, which is that of the zygote, and by a session whose leader has ended.
"""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from contextlib import suppress

from rtkit.link import places
from rtkit.manager.predecessor.unreported import is_slave

ZYGOTE = "rtkit.manager.slaves.zygote"
"""The module that a zygote runs, with two arguments: a descriptor, and its settings."""


def end_lost(manager: str) -> list[int]:
    """Kill those of a manager of that name; return their pids."""
    ended, pattern = [], places.zygote_pattern(manager)
    for pid in _lost(manager, pattern):
        with suppress(ProcessLookupError):
            pidfd = os.pidfd_open(pid)
            try:
                if pattern == _pattern(pid):  # still, and so it is the one of the descriptor
                    signal.pidfd_send_signal(pidfd, signal.SIGKILL)
                    ended.append(pid)
            finally:
                os.close(pidfd)
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
    if ZYGOTE.encode() not in words:
        return ""
    try:
        settings = json.loads(words[words.index(ZYGOTE.encode()) + 2])
    except (ValueError, IndexError):
        return ""
    return str(settings.get("zygote", "")) if isinstance(settings, dict) else ""


def _has_lost_its_leader(pid: int, pattern: str) -> bool:
    try:
        leader = os.getsid(pid)
    except ProcessLookupError:
        return False
    return leader != pid and _pattern(leader) != pattern
