"""Words of ``rtmgr`` that take the name of a manager: start, stop, restart, status, run, dump."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.errors import Malformed, Partial, Refused, Unreachable
from rtkit.link import places
from rtkit.rtc.address import is_address
from rtkit.rtc.names import MANAGER_SUFFIX, check_instance_name

if TYPE_CHECKING:
    from rtkit.manager.launch import Started
    from rtkit.tree.managers import Status


def run_word(
    app: App,
    word: str,
    name: str,
    is_json: bool,
    wanted: tuple[str, tuple[str, ...], bool],
    file: str = "",
) -> int:
    """Start, stop, run, dump or report on the manager of that name; return the exit status.

    `wanted` is its configuration file, properties over it, and whether the file may be missing;
    `file` is where a dump goes.
    """
    typed = name.removesuffix(MANAGER_SUFFIX)
    if word in ("start", "run"):
        return _launch(app, word, typed, wanted)
    chosen = typed or os.environ.get("RTKIT_MANAGER") or "manager"
    from rtkit.tree import managers

    if is_address(chosen):
        chosen = managers.name_at(chosen, app.timeout_s)
    check_instance_name(chosen)

    if word == "restart":
        _restart(app, chosen)
    elif word == "stop":
        _stop(app, chosen)
    elif word == "dump":
        from rtkit.cli.managers.dumps import dump

        dump(app, chosen, file)
    else:
        _tell_status(chosen, managers.status(chosen, app.timeout_s), is_json)
    return 0


def _launch(app: App, word: str, typed: str, options: tuple[str, tuple[str, ...], bool]) -> int:
    from rtkit.manager import launch
    from rtkit.settings import configuration

    wanted = configuration.CommandLineSettings(*options)
    name = configuration.name(typed, configuration.read(wanted).settings)
    if is_address(name):
        port = name.rpartition(":")[2]
        where = "" if typed else " (of RTKIT_MANAGER)"
        hint = f"rtmgr {word} NAME -p {port} has one listen there"
        raise Malformed(f"an address is no name of a manager: {name}{where} ({hint})")
    check_instance_name(name)
    if word == "run":
        return launch.run(name, wanted)
    _tell_start(app, name, launch.start(name, wanted, app.timeout_s))
    return 0


def _stop(app: App, name: str) -> None:
    """Stop a manager, or end the orphans of a killed one."""
    from rtkit.link.segments import remove_orphans
    from rtkit.tree import managers

    absent = None
    try:
        managers.stop(name, app.timeout_s)
    except Unreachable as error:
        if places.owner(name) is not None:
            raise
        absent = error
    left = _end_remains(name)
    remove_orphans()  # its own, which it held until it ended
    is_forgotten = absent is not None and _forget_desired_state(name)
    if absent is not None and not left and not is_forgotten:
        raise absent
    told = [f"had been killed; what it left was ended ({left} slaves)"] if left else []
    if is_forgotten:
        told = told or ["does not run"]
        told.append("what it kept for its next start is removed")
    if told:
        app.fail(f"manager {name!r} {'; '.join(told)}")
    else:
        app.tell(f"manager {name} ended")


def _end_remains(name: str) -> int:
    from rtkit.link.running import traces

    own = (places.manager_socket(name), places.control_socket(name), places.manager_lock(name))
    if not traces(name) and not any(map(os.path.lexists, own)):
        return 0
    from rtkit.manager.predecessor.stale_resources import end_remains

    return end_remains(name)


def _forget_desired_state(name: str) -> bool:
    """Remove the desired state of a stopped manager; return whether there was any."""
    from rtkit.manager.store.store import remove, take_over_former_name

    path = places.store_file(name)
    if not os.path.lexists(path) and not os.path.lexists(places.former_store_file(path)):
        return False
    from contextlib import ExitStack

    from rtkit.manager.claim import take_lock

    places.make_private(places.runtime_path())
    with ExitStack() as stack:
        take_lock(name, stack)
        take_over_former_name(path)
        return remove(path)


def _restart(app: App, name: str) -> None:
    from rtkit.manager.launch import hear, read_report
    from rtkit.tree import managers

    pid, told = managers.restart(name, app.timeout_s, hear)
    _tell_start(app, name, read_report(name, pid, told))


def _tell_start(app: App, name: str, started: Started) -> None:
    for text in started.warnings:
        app.fail(f"warning: {text}")
    if started.failures:
        why = f"manager {name} runs (pid {started.pid}), but not all of its start was done"
        raise Partial(why, [(text, Refused(text)) for text in started.failures])
    app.tell(f"manager {name} runs: pid {started.pid}, socket {places.manager_socket(name)}")


def _tell_status(name: str, status: Status, is_json: bool) -> None:
    if is_json:
        record = {
            "name": name,
            "pid": status.pid,
            "uptime_s": status.uptime_s,
            "components": status.components,
            "slaves": status.slaves,
            "socket": status.socket,
            "address": status.address,
        }
        terminal.write([json_records.line("manager-status", record)])
        return
    rows = [
        ("Name", name),
        ("Process ID", str(status.pid)),
        ("Uptime", f"{status.uptime_s:.0f} s"),
        ("Components", str(status.components)),
        ("Slaves", str(status.slaves)),
        ("Socket", status.socket),
        ("Address", status.address or "none (-p gives a manager one when it starts)"),
    ]
    terminal.write(terminal.pairs(rows, ""))
