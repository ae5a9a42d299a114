"""``rtmgr dump`` and ``rtmgr replay``: what a manager did last, as a file and again."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.errors import Malformed, NotFound, Refused

if TYPE_CHECKING:
    from rtkit.manager.core.dump import Dump
    from rtkit.manager.core.replay import Replay

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
    from rtkit.cli.shared.atomic import STDOUT, write_output
    from rtkit.tree.connect import connect

    output = file or f"{name}.dump"
    if output != STDOUT and os.path.lexists(output):
        raise Refused(f"{output} is there already")
    with connect(name, app.timeout_s) as tree:
        text = tree.dump()
    write_output(text.encode(), output, is_new=output != STDOUT, mode=0o600)
    app.tell(f"manager {name}: {output}, {len(text)} bytes")


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
        return _tell_json(file, found, run)
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
        map(terminal.printable, _told(found, run, None if app.is_verbose else _MOST_SHOWN))
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


def _told(found: Dump, run: Replay, most: int | None) -> Iterator[str]:
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


def _tell_json(file: str, found: Dump, run: Replay) -> int:
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
