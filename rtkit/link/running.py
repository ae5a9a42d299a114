"""Lists the managers of this user that run on this host: those that hold the lock of their name.

Explains also why a manager that was asked for does not run.
"""

from __future__ import annotations

import os
import stat
from contextlib import suppress

from rtkit.errors import Refused
from rtkit.link import places

_LOCK = ".lock"
_SOCKET = ".sock"


def managers() -> list[str]:
    """Return the names of the managers that run, in order."""
    try:
        entries = os.listdir(places.runtime_dir())
    except OSError:
        return []
    names = (entry.removesuffix(_LOCK) for entry in entries if entry.endswith(_LOCK))
    return sorted(
        name for name in names if not name.endswith(_SOCKET) and places.owner(name) is not None
    )


def services() -> list[str]:
    """Return the names of the property services of this user that answer, in order."""
    return [name for name in places.services() if is_service(name)]


def is_service(name: str) -> bool:
    """Return whether a property service of that name, of this user, answers."""
    from rtkit.link import unix

    return unix.is_answering(places.service_socket(name))


def traces(name: str, wanted: str = "") -> dict[int, str]:
    """Return by pid the files ``NAME.PID.KIND``, of one kind or any, of a manager's processes."""
    found = {}
    with suppress(OSError):
        folder = places.runtime_dir()
        for entry in os.listdir(folder):
            pid, _, kind = entry.removeprefix(f"{name}.").partition(".")
            if entry == f"{name}.{pid}.{kind}" and pid.isdigit() and wanted in ("", kind):
                found[int(pid)] = os.path.join(folder, entry)
    return found


def why_absent(name: str, host: str = "") -> str:
    """Return the message about a manager that does not run, with a hint.

    With `host`, the message is for who asks from another host, which knows this one by that name.
    """
    folder = places.runtime_path()
    absent = f"manager {name!r} is not running"
    if os.path.lexists(folder):
        try:
            places.check_private(folder)
        except Refused as error:
            return f"manager {name!r} cannot be reached: {error}"
    path = places.manager_socket(name)
    start = f"rtmgr start{_name(name)}{host and f' --host {places.quoted(host)}'}"
    try:
        is_socket = stat.S_ISSOCK(os.lstat(path).st_mode)
    except OSError:
        from rtkit.rtc.nearest import did_you_mean

        if near := did_you_mean(name, managers()):
            return f"{absent}{near}"
        others = ", ".join(managers())
        return f"{absent} (start it with: {start}{f'; running: {others}' * bool(others)})"
    if not is_socket:
        return f"{absent}: {path} is no socket (remove it, then: {start})"
    return f"{absent}: nobody is behind its socket {path} (start it with: {start})"


def _name(name: str) -> str:
    is_usual = name == places.DEFAULT_MANAGER and not os.environ.get("RTKIT_MANAGER")
    return "" if is_usual else f" {places.quoted(name)}"
