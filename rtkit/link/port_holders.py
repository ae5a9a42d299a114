"""Finds the process that listens on a TCP port, as far as the kernel shows it to this user."""

from __future__ import annotations

import os
from typing import NamedTuple

_TABLES = ("/proc/net/tcp", "/proc/net/tcp6")
_LISTENING = "0A"
SERVANT = "rtkit TCP port"
"""Name of a process that serves a port for the manager that started it."""


class PortHolder(NamedTuple):
    """Process that listens on a port; `pid` is 0 where the process is another user's."""

    uid: int
    pid: int = 0
    name: str = ""

    def __str__(self) -> str:
        if self.pid:
            return f"{self.name} (pid {self.pid})"
        return f"a process of user {user_name(self.uid)}"


def port_holder(port: int) -> PortHolder | None:
    """Return who listens on a port, a manager where its servant does; None for nobody."""
    found = listener(port)
    if found is None or found.name != SERVANT:
        return found
    from rtkit.link.processes import stat_of

    fields = stat_of(found.pid)
    parent = int(fields[1]) if fields else 0
    return PortHolder(found.uid, parent, _name(parent)) if parent > 1 else found


def listener(port: int) -> PortHolder | None:
    """Return the process that listens on a port; None for none."""
    found = _listening(port)
    if found is None:
        return None
    uid, inode = found
    pid = _process_with(f"socket:[{inode}]")
    return PortHolder(uid, pid, _name(pid)) if pid else PortHolder(uid)


def _listening(port: int) -> tuple[int, str] | None:
    for table in _TABLES:
        try:
            with open(table, encoding="ascii") as file:
                lines = file.readlines()[1:]
        except OSError:
            continue
        for line in lines:
            fields = line.split()
            if fields[3] == _LISTENING and int(fields[1].rpartition(":")[2], 16) == port:
                return int(fields[7]), fields[9]
    return None


def _process_with(link: str) -> int:
    for entry in os.listdir("/proc"):
        if not entry.isdigit():
            continue
        folder = f"/proc/{entry}/fd"
        try:
            numbers = os.listdir(folder)
        except OSError:
            continue  # another user's, or just ended
        for number in numbers:
            try:
                if os.readlink(f"{folder}/{number}") == link:
                    return int(entry)
            except OSError:
                continue
    return 0


def _name(pid: int) -> str:
    try:
        with open(f"/proc/{pid}/comm", encoding="utf-8", errors="replace") as file:
            return file.read().strip()
    except OSError:
        return "a process"


def user_name(uid: int) -> str:
    """Return what a user is called, else his number."""
    import pwd

    try:
        return pwd.getpwuid(uid).pw_name
    except KeyError:
        return str(uid)
