"""Processes that components started and left behind: found in ``/proc`` and ended."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator

_PARENT, _SESSION = 1, 3
"""Fields of ``/proc/PID/stat`` after the command's name: state, parent, group, session."""


def end_session(session: int) -> None:
    """Kill every process of a session whose leader, a slave, has ended."""
    _kill(lambda fields: fields[_SESSION] == str(session))


def end_children() -> None:
    """Kill and reap every child of this process, and the orphans that become its children."""
    own = str(os.getpid())
    while True:
        _kill(lambda fields: fields[_PARENT] == own)
        try:
            os.waitid(os.P_ALL, 0, os.WEXITED)
        except ChildProcessError:
            return


def _kill(is_meant: Callable[[list[str]], bool]) -> None:
    for pid, fields in _processes():
        if is_meant(fields):
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue


def _processes() -> Iterator[tuple[int, list[str]]]:
    for entry in os.listdir("/proc"):
        if not entry.isdigit():
            continue
        try:
            with open(f"/proc/{entry}/stat", encoding="utf-8", errors="replace") as file:
                text = file.read()
        except (FileNotFoundError, ProcessLookupError):
            continue
        yield int(entry), text.rpartition(")")[2].split()
