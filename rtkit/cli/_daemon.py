"""The words of ``rtmgr``: start, stop, status, run."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rtkit.cli import _out
from rtkit.cli._app import App
from rtkit.rtc.names import MANAGER_SUFFIX, check_instance_name

if TYPE_CHECKING:
    from rtkit.tree.managers import Status


def run_word(app: App, word: str, name: str, is_json: bool) -> int:
    """Start, stop, be, or tell about the manager of that name; return the exit status."""
    chosen = name.removesuffix(MANAGER_SUFFIX) or os.environ.get("RTKIT_MANAGER") or "manager"
    check_instance_name(chosen)
    if word in ("start", "run"):
        return _launch(app, word, chosen)
    from rtkit.tree import managers

    if word == "stop":
        managers.stop(chosen, app.timeout_s)
        app.tell(f"manager {chosen} ended")
    else:
        _tell_status(chosen, managers.status(chosen, app.timeout_s), is_json)
    return 0


def _launch(app: App, word: str, name: str) -> int:
    from rtkit.link.places import manager_socket
    from rtkit.manager import launch

    if word == "run":
        return launch.run(name)
    pid = launch.start(name, app.timeout_s)
    app.tell(f"manager {name} runs: pid {pid}, socket {manager_socket(name)}")
    return 0


def _tell_status(name: str, status: Status, is_json: bool) -> None:
    if is_json:
        from json import dumps

        record = {
            "schema": "rtkit.status/1",
            "name": name,
            "pid": status.pid,
            "uptime_s": status.uptime_s,
            "components": status.components,
            "slaves": status.slaves,
            "socket": status.socket,
        }
        _out.write([dumps(record)])
        return
    rows = [
        ("Name", name),
        ("Process ID", str(status.pid)),
        ("Uptime", f"{status.uptime_s:.0f} s"),
        ("Components", str(status.components)),
        ("Slaves", str(status.slaves)),
        ("Socket", status.socket),
    ]
    _out.write(_out.pairs(rows, ""))
