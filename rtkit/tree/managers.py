"""Managers as processes of this host: their status, restart and end."""

from __future__ import annotations

import os
import select
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from rtkit import fault
from rtkit.errors import NotFound, Unreachable
from rtkit.link import places
from rtkit.rtc.names import is_local_host
from rtkit.tree.client import bounded
from rtkit.tree.connect import connect

if TYPE_CHECKING:
    from rtkit.logs.logbook import LogEntry


_AGAIN_S = 0.2
"""Between two tries to reach a manager that starts [s]."""
_REPORT = "rtkit.manager.report"
_READY = "ready"
"""Logger of what a manager reports of its start, and the last line of that."""


class Status(NamedTuple):
    """Status that a running manager reports; uptime in [s].

    Attributes:
        socket: Empty for one of another host.
        address: Of its port for this user, empty if it has none.
        tls: Of its port for certificates, likewise.
    """

    pid: int
    uptime_s: float
    components: int
    slaves: int
    socket: str
    address: str
    tls: str = ""


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


def stop_at(address: str, timeout_s: float, *, is_kept: bool = False) -> None:
    """Stop the manager of another host at an address, and return when it has hung up.

    Raises:
        Refused: This user may not.
        Unreachable: It cannot be reached, or did not end in time.
    """
    over = threading.Event()
    with connect(address, timeout_s) as tree:
        end = tree.notice(lambda is_there: None if is_there else over.set())
        tree.set("stop", "keep" if is_kept else "")
        has_ended = over.wait(bounded(timeout_s))
        end()
    if not has_ended:
        raise Unreachable(f"the manager at {address} did not end within {timeout_s:g} s")


def restart_at(
    address: str, timeout_s: float, *, is_forgotten: bool = False
) -> tuple[int, list[str]]:
    """Have the manager of another host at an address end everything and start again.

    Return its pid, and what it reported of its start, by its log. It has `timeout_s` [s] for the
    end, and again for the start.

    Raises:
        Refused: This user may not.
        Unreachable: It cannot be reached, or was not ready in time.
    """
    from rtkit.logs.selection import Selection
    from rtkit.tree.far_logs import FarLogbook

    asked_at = time.monotonic()
    until = asked_at + 2 * bounded(timeout_s)
    over = threading.Event()
    with connect(address, timeout_s) as tree:
        end = tree.notice(lambda is_there: None if is_there else over.set())
        began = tree.get("manager.started")
        tree.set("restart", "forget" if is_forgotten else "")
        over.wait(bounded(timeout_s))
        end()
    while True:
        with suppress(Unreachable), connect(address, timeout_s) as tree:
            since_s = time.monotonic() - asked_at
            wanted = Selection(level="INFO", sources=(_REPORT,), since_s=since_s)
            with FarLogbook(tree, wanted) as book:
                lines = [_line(each) for each in book.there(is_followed=False)]
            if tree.get("manager.started") != began and _READY in lines:
                return int(tree.get("manager.pid")), lines
        if time.monotonic() > until:
            raise Unreachable(
                f"the manager at {address} was not ready again within {2 * timeout_s:g} s"
            )
        time.sleep(_AGAIN_S)


def _line(record: LogEntry) -> str:
    """Return a record as the line that the starter of a manager reads (`rtkit.manager.report`)."""
    kinds = {"ERROR": "failure ", "WARN": "warning "}
    return f"{kinds.get(record.level, '')}{record.message}"


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
    tls = ""
    with connect(name, timeout_s) as tree:
        listing = tree.listing()
        if is_local_host(tree.host, places.host_name()):
            # The same clock, and that of the wall may have been set meanwhile.
            now_s = time.clock_gettime(time.CLOCK_BOOTTIME)
            uptime_s = now_s - float(tree.get("manager.started_after_boot"))
            address, socket = tree.get("rtkit.address"), places.manager_socket(tree.manager)
        else:
            uptime_s = max(0.0, time.time() - float(tree.get("manager.started")))
            address, socket = "", ""
        with suppress(NotFound):  # of a manager that is older than its commands
            tls = tree.get("rtkit.tls_address")
    return Status(
        listing.pid, uptime_s, len(listing.rows), len(listing.slaves), socket, address, tls
    )
