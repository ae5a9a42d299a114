"""Managers as processes of this host: their status, restart and end."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable
from typing import NamedTuple

from rtkit import fault
from rtkit.errors import Unreachable
from rtkit.link import places
from rtkit.tree.client import bounded
from rtkit.tree.connect import connect


class Status(NamedTuple):
    """Status that a running manager reports; uptime in [s]."""

    pid: int
    uptime_s: float
    components: int
    slaves: int
    socket: str
    address: str


def name_at(address: str, timeout_s: float) -> str:
    """Return the name of the manager that listens at an address.

    Raises:
        Unreachable: None of this user answers there.
    """
    with connect(address, timeout_s) as tree:
        return tree.manager


def stop(name: str, timeout_s: float, *, is_kept: bool = False) -> None:
    """Stop a manager with all its slaves and return when its process has ended.

    What it holds is there again at its next start only if it `is_kept`.

    Raises:
        Unreachable: It does not run, or did not end in time.
    """
    with connect(name, timeout_s) as tree:
        try:
            pidfd = os.pidfd_open(int(tree.get("manager.pid")))
        except ProcessLookupError:
            return  # somebody else has stopped it meanwhile
        try:
            tree.set("stop", "keep" if is_kept else "")
            fault.point("stop.asked")
            if not select.select([pidfd], [], [], bounded(timeout_s))[0]:
                raise Unreachable(f"manager {name!r} did not end within {timeout_s:g} s")
        finally:
            os.close(pidfd)


def restart(
    name: str,
    timeout_s: float,
    receive: Callable[[int, float], list[str] | None],
    *,
    is_forgotten: bool = False,
) -> tuple[int, list[str]]:
    """Have a manager end everything and start again; return its pid and what `receive` returned.

    Everything is made again as it was, unless it `is_forgotten`.

    It has `timeout_s` [s] for the end, where what hangs has its graces, and again for the start.

    Raises:
        Unreachable: It does not run, or was not ready in time.
    """
    read, write = os.pipe()
    try:
        with connect(name, timeout_s) as tree:
            pipe = f"/proc/{os.getpid()}/fd/{write}"
            pid = int(tree.set("restart", f"{pipe} forget" if is_forgotten else pipe))
        os.close(write)
        write = -1
        lines = receive(read, 2 * timeout_s)
        if lines is None:
            raise Unreachable(f"manager {name!r} was not ready again within {2 * timeout_s:g} s")
        return pid, lines
    finally:
        os.close(read)
        if write >= 0:
            os.close(write)


def status(name: str, timeout_s: float) -> Status:
    """Ask a manager how it is.

    Raises:
        Unreachable: It does not run, or does not answer in time.
    """
    with connect(name, timeout_s) as tree:
        listing = tree.listing()
        # Of one host, so this clock is the same; that of the wall may have been set meanwhile.
        now_s = time.clock_gettime(time.CLOCK_BOOTTIME)
        uptime_s = now_s - float(tree.get("manager.started_after_boot"))
        address = tree.get("rtkit.address")
    socket = places.manager_socket(name)
    return Status(listing.pid, uptime_s, len(listing.rows), len(listing.slaves), socket, address)
