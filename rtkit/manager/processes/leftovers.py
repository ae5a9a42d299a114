"""Processes that components started and left behind: found in ``/proc`` and ended."""

from __future__ import annotations

import os
import signal
from collections.abc import Collection, Container, Iterator
from typing import NamedTuple

MARK = "RTKIT_SLAVE"
"""Environment variable by which what a slave starts is known, also in a session of its own."""


class _Process(NamedTuple):
    pid: int
    state: str
    parent: int
    session: int

    @property
    def is_over(self) -> bool:
        """Whether it only waits to be reaped."""
        return self.state in "ZX"


def end_sessions(leaders: Collection[int], *, is_heir: bool = True) -> None:
    """Kill what is left of slaves: their sessions, and orphans that bear their marks.

    One look through all processes serves any number of slaves. A slave may call it for itself,
    last of all.

    Args:
        leaders: The slaves, which have ended.
        is_heir: Their orphans have become children of this process; else they may be anywhere.
    """
    own = os.getpid()
    killed = {own}
    while True:
        present = [process for process in _processes() if not process.is_over]
        # Who lives under the pid of one that has ended is a stranger, with a session of its own.
        strangers = {process.pid for process in present} - {own}
        ended = set(leaders) - strangers
        marks = {f"{MARK}={leader}".encode() for leader in ended}
        left = [
            process.pid
            for process in present
            if process.pid not in killed
            and (
                process.session in ended
                or (
                    (process.parent == own or not is_heir)
                    and not marks.isdisjoint(_environment(process.pid))
                )
            )
        ]
        if not left:
            return
        for pid in left:
            _kill(pid)
        killed.update(left)


def end_children() -> None:
    """Kill and reap every child of this process, and the orphans that become its children."""
    own = os.getpid()
    while True:
        for process in _processes():
            if process.parent == own and not process.is_over:
                _kill(process.pid)
        try:
            os.waitid(os.P_ALL, 0, os.WEXITED)
        except ChildProcessError:
            return


def reap_orphans(known: Container[int]) -> list[int]:
    """Reap what ended and had been left to this process; return its pids.

    Neither those in `known`, who are waited for by name, nor what code in this process started:
    that code waits itself and wants the exit status.
    """
    own, session = os.getpid(), os.getsid(0)
    reaped = []
    for pid, _, parent, its_session in [each for each in _processes() if each.is_over]:
        if parent == own and its_session != session and pid not in known:
            try:
                os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG)
            except ChildProcessError:
                continue
            reaped.append(pid)
    return reaped


def _kill(pid: int) -> None:
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return


def _environment(pid: int) -> list[bytes]:
    try:
        with open(f"/proc/{pid}/environ", "rb") as file:
            return file.read().split(b"\0")
    except OSError:
        return []


def _processes() -> Iterator[_Process]:
    for entry in os.listdir("/proc"):
        if not entry.isdigit():
            continue
        try:
            with open(f"/proc/{entry}/stat", "rb") as file:
                text = file.read()
        except (FileNotFoundError, ProcessLookupError):
            continue
        state, parent, _group, session = text.rpartition(b")")[2].split()[:4]
        yield _Process(int(entry), state.decode(), int(parent), int(session))
