"""Finds processes that components started and left behind in ``/proc``, and ends them.

Zygote, slaves and manager are subreapers: each inherits the orphans below it. So what a component
daemonises stays below its slave while that lives, and below the zygote after that, which ends it;
whatever its session and its environment are. What is killed is killed by process groups: the
kernel lets no member of one fork meanwhile, where processes killed one by one may multiply.

See decision 42.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Collection, Container, Iterator, Mapping
from contextlib import suppress
from functools import cache
from typing import Any, NamedTuple

from rtkit.link.processes import stat_of

MARK = "RTKIT_SLAVE"
"""Environment variable by which what a slave starts is known, also in a session of its own."""


_LOOKS = 2
"""How often in succession nothing is to be left: a list of children may lack one now and then."""


_BEGAN = 15
"""Index of the start time, behind the session [ticks since the machine began]."""


_PR_SET_CHILD_SUBREAPER = 36


class _Process(NamedTuple):
    pid: int
    state: str
    parent: int
    group: int
    session: int
    began: int

    @property
    def is_over(self) -> bool:
        """Return whether the process only waits to be reaped."""
        return self.state in "ZX"


def become_subreaper() -> None:
    """Have orphans of this process's descendants become its children; forks do not inherit it.

    Raises:
        OSError: The kernel refuses.
    """
    libc = _libc()
    if libc.prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0):
        import ctypes

        raise OSError(ctypes.get_errno(), "cannot become subreaper")


@cache
def _libc() -> Any:
    """Return the C library: made once, as it costs 6 ms, and each slave that makes its own 130 kB.

    The zygote makes it when nobody waits.
    """
    import ctypes

    return ctypes.CDLL(None, use_errno=True)


def end_sessions(
    leaders: Collection[int], *, is_heir: bool = True, is_ancestor: bool = False
) -> None:
    """Kill what is left of slaves: their sessions, and orphans that bear their marks.

    One look through all processes serves any number of slaves. A slave may call it for itself,
    last of all.

    Args:
        leaders: The slaves, which have ended.
        is_heir: Their orphans have become children of this process; else they may be anywhere.
        is_ancestor: All that they started descends from this process; to look there is enough.
    """
    own = os.getpid()
    killed = {own}
    clean_looks = 0
    while clean_looks < (_LOOKS if is_ancestor else 1):
        processes = _descendants(own) if is_ancestor else _processes()
        present = [process for process in processes if not process.is_over]
        # A process that reuses the pid of an ended one is a stranger, with a session of its own.
        strangers = {leader for leader in leaders if leader != own and _is_alive(leader)}
        ended = set(leaders) - strangers
        for leader in ended - {own}:
            _kill_group(leader)  # also what was born and has died since the look
        marks = {f"{MARK}={leader}".encode() for leader in ended}
        left = [
            process
            for process in present
            if process.pid not in killed
            and (
                process.session in ended
                or (
                    (process.parent == own or not is_heir)
                    and not marks.isdisjoint(environment_of(process.pid))
                )
            )
        ]
        clean_looks = 0 if left else clean_looks + 1
        _kill_with_groups(left)
        killed.update(process.pid for process in left)


def end_children() -> None:
    """Kill and reap every child of this process, and the orphans that become its children."""
    own = os.getpid()
    while _has_children():  # mostly there are none: no need to read who they are
        for pid in _children(own):
            _kill(pid)
        with suppress(ChildProcessError):
            os.waitid(os.P_ALL, 0, os.WEXITED)


def _has_children() -> bool:
    """Return whether this process has any children, also ones that ended and were not reaped."""
    try:
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return False
    return True


def end_orphans(known: Container[int]) -> list[tuple[int, str]]:
    """Kill the children of this process that are not `known`, and all below them.

    They are reaped by who waits for children; what escapes them becomes a child in turn. Returns
    pid and name of each.
    """
    ended = []
    for child in [pid for pid in _children(os.getpid()) if pid not in known]:
        process = _process(child)
        left = [] if process is None else [process, *_descendants(child)]
        names = [(each.pid, _name(each.pid)) for each in left]
        _kill_with_groups([each for each in left if not each.is_over])
        ended += [(pid, name) for pid, name in names if name]
    return ended


def family(pid: int) -> dict[int, int]:
    """Return what descends from a process: when each began, by pid."""
    return {each.pid: each.began for each in _descendants(pid) if not each.is_over}


def family_beside(known: Collection[int]) -> dict[int, int]:
    """Return what descends from this process but for those children and what is below them."""
    found: dict[int, int] = {}
    for pid in _children(os.getpid()):
        if pid not in known and (began := began_at(pid)):
            found.update({pid: began, **family(pid)})
    return found


def began_at(pid: int) -> int:
    """Return when a process began [ticks]; 0 when it is over."""
    process = _process(pid)
    return 0 if process is None or process.is_over else process.began


def end_family(known: Mapping[int, int]) -> None:
    """Kill what is left of such a family, and no stranger who got a pid of it."""
    for pid, began in known.items():
        process = _process(pid)
        if process is not None and process.began == began:
            _kill(pid)


class Adopted:
    """Reaps orphans that became children of this process and have ended since.

    What code in this process started it waits for itself: so only what has been over since the
    last look, and stands in nobody's way, is reaped.
    """

    def __init__(self) -> None:
        self._over: set[int] = set()

    def look(self) -> None:
        """Reap what was over at the last look already."""
        processes = [_process(pid) for pid in _children(os.getpid())]
        over = {each.pid for each in processes if each is not None and each.is_over}
        for pid in over & self._over:
            with suppress(ChildProcessError):
                os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG)
        self._over = over - self._over


def is_stopped(pid: int) -> bool:
    """Return whether a process was stopped and has not continued yet."""
    process = _process(pid)
    return process is not None and process.state in "Tt"


def reap_orphans(known: Container[int]) -> list[int]:
    """Reap what ended and had been left to this process; return its pids.

    Neither those in `known`, who are waited for by name, nor what code in this process started:
    that code waits itself and wants the exit status.
    """
    own, session = os.getpid(), os.getsid(0)
    reaped = []
    for pid in [each for each in _children(own) if each not in known]:
        process = _process(pid)
        if process is None or not process.is_over or process.session == session:
            continue
        try:
            os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG)
        except ChildProcessError:
            continue
        reaped.append(pid)
    return reaped


def _name(pid: int) -> str:
    """Return what a process that is not over is called; empty for one that is."""
    try:
        with open(f"/proc/{pid}/comm", encoding="utf-8", errors="replace") as file:
            return file.read().strip() if _is_alive(pid) else ""
    except OSError:
        return ""


def end_slave(pid: int, pidfd: int) -> None:
    """Kill a slave, and its process group if it leads one.

    Raises:
        ProcessLookupError: It has ended.
    """
    signal.pidfd_send_signal(pidfd, 0)  # a stranger may have its pid
    if os.getpgid(pid) == pid:
        _kill_group(pid)
    signal.pidfd_send_signal(pidfd, signal.SIGKILL)


def _kill_with_groups(processes: Collection[_Process]) -> None:
    """Kill processes and their process groups, but for the group of this process."""
    own = os.getpgrp()
    for group in {process.group for process in processes} - {own, 0}:
        _kill_group(group)
    for process in processes:
        if process.group in (own, 0):
            _kill(process.pid)


def _kill_group(leader: int) -> None:
    with suppress(ProcessLookupError):
        os.killpg(leader, signal.SIGKILL)


def _kill(pid: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def environment_of(pid: int) -> list[bytes]:
    """Return what a process was given as environment; nothing if it is another user's."""
    try:
        with open(f"/proc/{pid}/environ", "rb") as file:
            return file.read().split(b"\0")
    except OSError:
        return []


def _is_alive(pid: int) -> bool:
    process = _process(pid)
    return process is not None and not process.is_over


def _processes() -> Iterator[_Process]:
    for entry in os.listdir("/proc"):
        process = _process(int(entry)) if entry.isdigit() else None
        if process is not None:
            yield process


def _descendants(pid: int) -> Iterator[_Process]:
    for child in _children(pid):
        process = _process(child)
        if process is not None:
            yield process
            yield from _descendants(child)


def _children(pid: int) -> list[int]:
    """Return the children of a process; while some of them end one may be missing."""
    if not os.path.exists("/proc/thread-self/children"):  # not every kernel lists them
        return [process.pid for process in _processes() if process.parent == pid]
    children: list[int] = []
    try:
        for thread in os.listdir(f"/proc/{pid}/task"):
            with open(f"/proc/{pid}/task/{thread}/children", "rb", buffering=0) as file:
                children.extend(map(int, file.read().split()))
    except (FileNotFoundError, ProcessLookupError):
        pass
    return children


def _process(pid: int) -> _Process | None:
    fields = stat_of(pid)
    if not fields:
        return None
    state, parent, group, session, *more = fields
    return _Process(pid, state.decode(), int(parent), int(group), int(session), int(more[_BEGAN]))
