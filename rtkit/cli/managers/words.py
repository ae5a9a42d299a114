"""Words of ``rtmgr`` that take no path: start, stop, restart, status, install, dump and others."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.errors import Malformed, NotFound, Partial, Refused, Unreachable, UsageProblem
from rtkit.link import places
from rtkit.rtc.manager_address import is_address
from rtkit.rtc.names import MANAGER_SUFFIX, check_instance_name

if TYPE_CHECKING:
    from rtkit.cli.managers.word_options import WordOptions
    from rtkit.manager.core.dump import Dump
    from rtkit.manager.core.replay import Replay
    from rtkit.manager.launch import Started
    from rtkit.tree.managers import Status


def run_word(
    app: App,
    word: str,
    name: str,
    options: WordOptions,
    wanted: tuple[str, tuple[str, ...], bool],
    shows: str,
    file: str = "",
) -> int:
    """Start, stop, run, install, dump or report on a manager of that name; return the exit status.

    `wanted` is its configuration file, properties over it, and whether the file may be missing;
    `shows` is ``json`` or ``text`` where that is asked for; `file` is where a dump goes.
    """
    typed = name.removesuffix(MANAGER_SUFFIX)
    if options.hosts:
        from rtkit.cli.hosts.far_managers import run_at_hosts

        if any(wanted):
            kinds = "-f, -o, -p, -a, -i, --tls, --allow-faults"
            raise UsageProblem(f"--host starts a manager as it is by default: no {kinds}")
        how = {"replaces": options.replaces, "is_kept": options.is_kept}
        return run_at_hosts(app, word, options.hosts, typed, **how)
    if word in ("start", "run", "install"):
        return _launch(app, word, typed, wanted, options, shows)
    chosen = typed or places.usual_manager()
    from rtkit.tree import managers
    from rtkit.tree.place import is_far_address

    if is_far_address(chosen):
        return _run_far(app, word, chosen, options, shows, file)
    if is_address(chosen):
        chosen = managers.name_at(chosen, app.timeout_s)
    check_instance_name(chosen)

    if word == "restart":
        _restart(app, chosen, is_forgotten=options.is_forgotten)
    elif word == "stop":
        _stop(app, chosen, is_kept=options.is_kept)
    elif word == "uninstall":
        from rtkit.cli.managers.service import uninstall

        uninstall(app, chosen, options)
    elif word == "dump":
        dump(app, chosen, file)
    else:
        _print_status(chosen, managers.status(chosen, app.timeout_s), shows == "json")
    return 0


def _run_far(app: App, word: str, address: str, options: WordOptions, shows: str, file: str) -> int:
    """Stop, restart, dump or report on the manager of another host at a port for certificates."""
    from rtkit.tree import managers

    if word == "stop":
        managers.stop_at(address, app.timeout_s, is_kept=options.is_kept)
    elif word == "restart":
        from rtkit.manager.launch import read_report

        forgets = options.is_forgotten
        pid, report = managers.restart_at(address, app.timeout_s, is_forgotten=forgets)
        _report_start(app, address, read_report(address, pid, report))
    elif word == "status":
        _print_status(address, managers.status(address, app.timeout_s), shows == "json")
    elif word == "dump":
        dump(app, address, file or f"{address.replace(':', '_')}.dump")
    else:
        raise Refused(f"{address} is on another host: {word} can be had on that host only")
    return 0


def _launch(
    app: App,
    word: str,
    typed: str,
    given: tuple[str, tuple[str, ...], bool],
    options: WordOptions,
    shows: str,
) -> int:
    from rtkit.manager import launch
    from rtkit.settings import configuration

    wanted = configuration.CommandLineSettings(*given)
    name = configuration.name(typed, configuration.read(wanted).settings)
    if is_address(name):
        port = name.rpartition(":")[2]
        where = "" if typed else " (of RTKIT_MANAGER)"
        hint = f"rtmgr {word} NAME -p {port} has one listen there"
        raise Malformed(f"an address is no name of a manager: {name}{where} ({hint})")
    check_instance_name(name)
    if word == "install":
        from rtkit.cli.managers.service import install

        install(app, name, given, options, shows=shows)
        return 0
    if word == "run":
        return launch.run(name, wanted)
    _report_start(app, name, launch.start(name, wanted, app.timeout_s))
    return 0


def _stop(app: App, name: str, *, is_kept: bool) -> None:
    """Stop a manager, or end the orphans of a killed one."""
    from rtkit.tree import managers

    absent = None
    try:
        managers.stop(name, app.timeout_s, is_kept=is_kept)
    except Unreachable as error:
        if places.owner(name) is not None:
            raise
        absent = error
    left = _end_remains(name)
    is_forgotten = absent is not None and not is_kept and _forget_desired_state(name)
    if absent is not None and not left and not is_forgotten:
        raise absent
    notes = [f"had been killed; what it left was ended ({left} slaves)"] if left else []
    if is_forgotten:
        notes = notes or ["does not run"]
        notes.append("what it kept for its next start is removed")
    if notes:
        app.fail(f"manager {name!r} {'; '.join(notes)}")
    else:
        app.verbose(f"manager {name} ended")


def _end_remains(name: str) -> int:
    from rtkit.link.running import traces

    own = (*places.sockets_of(name), places.manager_lock(name))
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


def _restart(app: App, name: str, *, is_forgotten: bool) -> None:
    from rtkit.manager.launch import read_report, receive_lines
    from rtkit.tree import managers

    pid, report = managers.restart(name, app.timeout_s, receive_lines, is_forgotten=is_forgotten)
    _report_start(app, name, read_report(name, pid, report))


def _report_start(app: App, name: str, started: Started) -> None:
    for text in started.warnings:
        app.fail(f"warning: {text}")
    if started.failures:
        why = f"manager {name} runs (pid {started.pid}), but not all of its start was done"
        raise Partial(why, [(text, Refused(text)) for text in started.failures])
    at = "" if is_address(name) else f", socket {places.manager_socket(name)}"
    app.verbose(f"manager {name} runs: pid {started.pid}{at}")


def _print_status(name: str, status: Status, is_json: bool) -> None:
    if is_json:
        record = json_records.picked(status, "pid uptime_s components slaves socket address tls")
        terminal.write([json_records.line("manager-status", {"name": name, **record})])
        return
    rows = [
        ("Name", name),
        ("Process ID", str(status.pid)),
        ("Uptime", f"{status.uptime_s:.0f} s"),
        ("Components", str(status.components)),
        ("Slaves", str(status.slaves)),
        ("Socket", status.socket or "on its host"),
        ("Address", status.address or "none (-p gives a manager one when it starts)"),
        *([("TLS", status.tls)] if status.tls else []),
    ]
    terminal.write(terminal.pairs(rows, ""))


_MOST_BYTES = 64 << 20
"""The longest file that is read; one of 1,000 components has 2 MB."""
_MOST_SHOWN = 300
"""The longest line of an event or instruction, without -v."""


def dump(app: App, name: str, file: str) -> None:
    """Write the last events of a manager to a file of this user alone, which must be new.

    Raises:
        Unreachable: The manager does not answer in time.
        Refused: There is such a file.
        NotFound: It cannot be written.
    """
    from rtkit.link.atomic import STDOUT, write_output
    from rtkit.tree.connect import connect

    output = file or f"{name}.dump"
    if output != STDOUT and os.path.lexists(output):
        raise Refused(f"{output} is there already")
    with connect(name, app.timeout_s) as tree:
        text = tree.dump()
    write_output(text.encode(), output, is_new=output != STDOUT, mode=0o600)
    app.verbose(f"manager {name}: {output}, {len(text)} bytes")


def replay(app: App, file: str, is_json: bool) -> int:
    """Show what the core of a manager did, by a dump; return 1 if it does otherwise here.

    Raises:
        NotFound: There is no such file.
        Malformed: It is no dump that can be read here.
        Refused: It has no beginning.
    """
    from rtkit.manager.core.replay import Replay
    from rtkit.report.finding import counted
    from rtkit.version import __version__

    found = _read(file)
    run = Replay(found.recording)
    if found.header.get("rtkit") != __version__:
        app.fail(f"note: of rtkit {found.header.get('rtkit')}; this one may do otherwise")
    if is_json:
        return _print_json(file, found, run)
    header = found.header
    terminal.write(
        [
            terminal.printable(f"{header.get('why')} ({header.get('time')})"),
            terminal.printable(
                f"manager {header.get('manager')} on {header.get('host')}, pid {header.get('pid')};"
                f" {found.recording.lost} earlier events are not here"
            ),
        ]
    )
    terminal.write(
        map(terminal.printable, _replay_lines(found, run, None if app.is_verbose else _MOST_SHOWN))
    )
    nouns = {"process": "processes", "component": "components", "connector": "connectors"}
    ended = ", ".join(counted(len(getattr(run.state, nouns[noun])), noun) for noun in nouns)
    if run.differences:
        terminal.write([f"the end: {ended}; other than in the manager:"])
        terminal.write(terminal.printable(f"  {each}") for each in run.differences)
        return 1
    terminal.write([f"the end: {ended}, as in the manager"])
    return 0


def _read(file: str) -> Dump:
    from rtkit.manager.core.dump import from_lines

    try:
        with open(file, encoding="utf-8") as stream:
            text = stream.read(_MOST_BYTES + 1)
    except UnicodeDecodeError as error:
        raise Malformed(f"{file}: not a dump of a manager: not UTF-8 ({error.reason})") from error
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise NotFound(f"cannot read {file}: {why}") from error
    if len(text) > _MOST_BYTES:
        raise Malformed(f"{file}: longer than {_MOST_BYTES >> 20} MiB")
    try:
        return from_lines(text.splitlines())
    except Malformed as error:
        raise Malformed(f"{file}: {error}") from error


def _replay_lines(found: Dump, run: Replay, most: int | None) -> Iterator[str]:
    """Yield a line for each event, and below it what the core did; faults with their place."""
    from rtkit.manager.core.event_ring import Fault

    began = found.recording.items[0][0] if found.recording.items else 0.0
    for step in run.steps():
        at = f"{step.at - began:10.6f}"
        if isinstance(step.item, Fault):
            yield f"{at}  FAULT in {step.item.work}: {step.item.error}"
            yield from (f"            {line}" for line in step.item.trace.splitlines())
            continue
        yield f"{at}  {step.item}"[:most]
        yield from (f"            -> {each}"[:most] for each in step.instructions)
        if step.error:
            yield f"            {'FAULT' if step.is_bug else 'refused'}: {step.error}"


def _print_json(file: str, found: Dump, run: Replay) -> int:
    from rtkit.manager.core.event_ring import Fault

    steps = list(run.steps())
    record = {
        "file": file,
        **{key: found.header.get(key, "") for key in ("manager", "rtkit", "time", "why")},
        "events": sum(not isinstance(step.item, Fault) for step in steps),
        "lost": found.recording.lost,
        "faults": [
            {"work": step.item.work, "error": step.item.error}
            for step in steps
            if isinstance(step.item, Fault)
        ],
        "differences": run.differences,
    }
    terminal.write([json_records.line("replay", record)])
    return 1 if run.differences else 0
