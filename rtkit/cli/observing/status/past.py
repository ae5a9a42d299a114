"""Gathers what happened to an entry of the tree: events, log, the last crash, the last output."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.cli.observing.unseen import unseen_entries
from rtkit.cli.shared.json_records import time_text
from rtkit.container.exit_diagnostics import CRASH_HEAD, exit_diagnostics
from rtkit.errors import NotFound
from rtkit.link.places import state_dir
from rtkit.logs.logbook import Logbook

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts, ProcessFacts
    from rtkit.logs.logbook import LogEntry
    from rtkit.tree.client import Tree

_MANAGER = "rtkit.manager"
"""Loggers below this one tell what a manager did; where it labels a component, it is an event."""
_MOST_EVENTS = 10
_PRINTED = 10
"""How many lines before a crash are shown, though newer ones follow."""

Record = dict[str, Any]


class Past(NamedTuple):
    """The past of an entry.

    Attributes:
        crash: The last one; None if there was none.
        output: The last lines that a process which ended wrote past its log.
    """

    events: list[Record]
    log: list[Record]
    crash: Record | None
    output: list[str]


def past_of(
    tree: Tree | None,
    manager: str,
    facts: ComponentFacts | None,
    process: ProcessFacts | None,
    lines: int,
) -> Past:
    """Return the past of a component, or without `facts` of a process; `tree` is None offline."""
    file = manager
    if process is not None and process.is_slave:
        file = f"{manager}.{process.name}"
    entries = _entries(manager, file, facts.instance if facts is not None else "")
    crashes = [each for each in entries if _is_crash(each)]
    by_manager = [
        each for each in entries if facts is not None and each.source.startswith(_MANAGER)
    ]
    log = [each for each in entries if not _is_crash(each) and each not in by_manager]
    crash = _crash(crashes[-1], log) if crashes else None
    events = _events(tree, facts, by_manager)
    is_over = process is not None and bool(facts.zombie if facts else process.state == "lost")
    output: Sequence[str] = ()
    if is_over and process is not None:
        pid = crashes[-1].pid if crashes else process.pid or (log[-1].pid if log else 0)
        slave = process.name if process.is_slave else ""
        output = exit_diagnostics(manager, slave, pid).output
    shown = log[max(0, len(log) - lines) :]
    return Past(events, [_plain(each) for each in shown], crash, list(output))


def _entries(manager: str, file: str, instance: str) -> list[LogEntry]:
    """Return the records of a component, or of a process, and of the crashes of that process."""

    def is_wanted(entry: LogEntry) -> bool:
        if entry.file not in (manager, file):
            return False
        if instance and entry.component:
            return entry.component == instance
        return entry.file == file and (not instance or _is_crash(entry))

    logbook = Logbook(state_dir(), is_wanted, {manager, file})
    try:
        return logbook.there(None, unseen_entries(manager))
    finally:
        logbook.close()


def _is_crash(entry: LogEntry) -> bool:
    return entry.level == "FATAL" and entry.message.startswith(CRASH_HEAD)


def _crash(entry: LogEntry, log: Sequence[LogEntry]) -> Record:
    before = [each for each in log if each.pid == entry.pid and each.time <= entry.time]
    return {
        "time": _time(entry),
        "pid": entry.pid,
        "what": entry.message,
        "stack": entry.exception,
        "before": [_plain(each) for each in before[-_PRINTED:]],
    }


def _events(
    tree: Tree | None, facts: ComponentFacts | None, by_manager: Sequence[LogEntry]
) -> list[Record]:
    """Return the last events: those that the manager has, before them what its log has."""
    found: list[Record] = []
    if tree is not None and facts is not None:
        try:
            found = [
                {
                    "time": time_text(int(at * 1e9)),
                    "event": event,
                    "subject": subject,
                    "detail": detail,
                }
                for at, event, subject, detail in tree.past_events(facts.instance)
            ]
        except NotFound:
            found = []  # a manager of a version that tells none
    begin = found[0]["time"] if found else "9"
    logged = [
        {"time": _time(each), "event": "LOGGED", "subject": "", "detail": each.message}
        for each in by_manager
        if _time(each) < begin
    ]
    return [*logged, *found][-_MOST_EVENTS:]


def _plain(entry: LogEntry) -> Record:
    return {
        "time": _time(entry),
        "level": entry.level,
        "source": entry.source,
        "message": entry.message,
        "exception": entry.exception,
    }


def _time(entry: LogEntry) -> str:
    return f"{entry.time[:-1]}000Z"
