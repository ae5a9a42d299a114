"""Ends processes that a killed manager left running, found by the files they hold."""

from __future__ import annotations

import os
import select
import signal
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, suppress

from rtkit.container.orphans import end_sessions
from rtkit.errors import Refused
from rtkit.link import places, running, unix
from rtkit.manager.claim import remove_stale, take_lock
from rtkit.manager.predecessor.descendants import end_descendants
from rtkit.manager.predecessor.unregistered_forks import end_lost
from rtkit.manager.predecessor.unreported import is_slave, living_slaves

TERM_S = 7.0
"""Grace between TERM and KILL, in which components finalise [s]."""

_KILL_S = 5.0
_ZYGOTE_S = 1.0
_ZYGOTE = ".zygote"


def end_remains(name: str, term_s: float = TERM_S) -> int:
    """End the slaves of a manager of that name which does not run; return how many there were.

    Raises:
        Refused: It runs.
    """
    with ExitStack() as stack:
        take_lock(name, stack)
        slaves, zygotes = dict(_slaves(name)), dict(_zygotes(name))
        try:
            _end(slaves, term_s)
            _kill(zygotes, _living(zygotes.values(), _ZYGOTE_S))  # it ends with its last child
        finally:
            for pidfd in (*slaves.values(), *zygotes.values()):
                os.close(pidfd)
        end_sessions(slaves.keys(), is_heir=False)
        lost = end_lost(name)
        end_descendants(name)
        remove_stale(name, ())
    return len(slaves) + len(lost)


def _slaves(name: str) -> Iterator[tuple[int, int]]:
    """Yield pid and pidfd of each slave that runs."""
    for pid in living_slaves(name):
        try:
            pidfd = os.pidfd_open(pid)
        except OSError:
            continue
        if is_slave(name, pid):  # still, and so it is the one that the descriptor stands for
            yield pid, pidfd
        else:
            os.close(pidfd)


def _zygotes(name: str) -> Iterator[tuple[int, int]]:
    """Yield pid and pidfd of each process that forked them, which listens for the next manager."""
    for entry in running.traces(name):
        if not entry.endswith(_ZYGOTE):
            continue
        path = os.path.join(places.runtime_dir(), entry)
        with suppress(OSError), unix.connect(path) as connection:
            pid = unix.pid_of(connection)
            yield pid, os.pidfd_open(pid)


def _end(slaves: dict[int, int], term_s: float) -> None:
    for pidfd in slaves.values():
        _send(pidfd, signal.SIGTERM)
        _send(pidfd, signal.SIGCONT)
    _kill(slaves, _living(slaves.values(), term_s))


def _kill(processes: dict[int, int], pidfds: Iterable[int]) -> None:
    killed = list(pidfds)
    for pidfd in killed:
        _send(pidfd, signal.SIGKILL)
    left = _living(killed, _KILL_S)
    if left:
        pids = [str(pid) for pid, pidfd in processes.items() if pidfd in left]
        raise Refused(f"processes that do not end even when killed: {', '.join(pids)}")


def _send(pidfd: int, number: signal.Signals) -> None:
    with suppress(ProcessLookupError):
        signal.pidfd_send_signal(pidfd, number)


def _living(pidfds: Iterable[int], patience_s: float) -> list[int]:
    """Wait for processes to end; return the pidfds of those that do not in time."""
    poll = select.poll()
    left = set(pidfds)
    for pidfd in left:
        poll.register(pidfd, select.POLLIN)
    deadline = time.monotonic() + patience_s
    while left and (patience_ms := (deadline - time.monotonic()) * 1000) > 0:
        for pidfd, _ in poll.poll(patience_ms):
            poll.unregister(pidfd)
            left.discard(pidfd)
    return sorted(left)
