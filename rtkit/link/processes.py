"""Tells whether processes of this host live, even where their pids were reused."""

from __future__ import annotations

import os
import select
import signal
from contextlib import suppress

from rtkit.closing import Closing


class ProcessWatch(Closing):
    """Watch on one process, from now until it exits."""

    def __init__(self, pid: int) -> None:
        """Begin to watch.

        Raises:
            OSError: There is none of that id, or no descriptor is left.
        """
        self._descriptor = os.pidfd_open(pid)

    @property
    def is_over(self) -> bool:
        """Return whether it has ended."""
        return self.await_end(0.0)

    def await_end(self, timeout_s: float) -> bool:
        """Wait for its end, at most so long [s]; return whether it has ended."""
        watching = select.poll()  # unlike select, it takes descriptors of any number
        watching.register(self._descriptor, select.POLLIN)
        return bool(watching.poll(timeout_s * 1000))

    def send(self, number: int) -> None:
        """Send a signal to it, and to no other process that has its pid now."""
        with suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._descriptor, number)

    def close(self) -> None:
        """Watch it no more."""
        os.close(self._descriptor)


def is_abandoned(path: str, pid: int) -> bool:
    """Return whether the process that bound a socket, which had that pid, is no more.

    The kernel lists which paths are bound in a network namespace; who lives in another one is
    believed to be the owner.
    """
    if state_of(pid) in ("", "Z", "X"):
        return True
    try:
        is_near = os.stat(f"/proc/{pid}/ns/net").st_ino == os.stat("/proc/self/ns/net").st_ino
    except FileNotFoundError:
        return True  # it has ended meanwhile
    except PermissionError:
        return True  # somebody else's: in the folder of this user it has nothing
    return is_near and not _is_bound(path)


def stat_of(pid: int) -> list[bytes]:
    """Return what the kernel tells of a process, from its state on; nothing when it is gone.

    Source: proc(5), ``/proc/PID/stat`` from field 3 on.
    """
    with suppress(OSError), open(f"/proc/{pid}/stat", "rb", buffering=0) as file:
        return file.read().rpartition(b")")[2].split()
    return []


def state_of(pid: int) -> str:
    """Return the state of a process, one letter as the kernel tells it; empty without one."""
    return next(iter(stat_of(pid)), b"").decode()


def _is_bound(path: str) -> bool:
    """Source: proc_net(5), the last column of ``/proc/net/unix``."""
    name, folder = os.path.basename(path), os.path.realpath(os.path.dirname(path))
    with open("/proc/net/unix", encoding="utf-8", errors="surrogateescape") as file:
        rows = (line.rstrip("\n").split(None, 7) for line in file)
        paths = [row[7] for row in rows if len(row) == 8]
    return any(
        os.path.basename(each) == name and os.path.realpath(os.path.dirname(each)) == folder
        for each in paths
    )
