"""``rtvlog``: print what components log."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import closing
from typing import TYPE_CHECKING

import click

from rtkit.api.logs import LEVELS, about, about_name, all_of, pieces, selected
from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import (
    POSITIVE,
    WordChoice,
    arguments,
    json_flag,
    lasting,
    option,
    several,
)
from rtkit.errors import Malformed, Unreachable

if TYPE_CHECKING:
    from rtkit.tree.logbook import LogEntry, Wanted

_BEFORE = 10
_STYLES = {
    "FATAL": "bold white on red",
    "ERROR": "bold red",
    "WARN": "yellow",
    **dict.fromkeys(LEVELS[LEVELS.index("DEBUG") :], "dim"),
}


@command(
    "rtvlog",
    examples=(
        ("rtvlog /localhost/Robot0.rtc", "What a component logs: the last lines, then what comes."),
        ("rtvlog -l warn /", "Warnings and errors of everything."),
        ("rtvlog --no-follow -n 20 Robot0.rtc", "The last 20 records, also of a zombie."),
        ("rtvlog -f stdout /localhost/manager.mgr/drives.mgr", "What code in a slave printed."),
    ),
    json=("log-record",),
    arguments=("anything",),
)
def main(
    app: App,
    sources: tuple[str, ...] = several(
        "-f --filter SOURCE", "Print only what this logger, or one below it, says; ALL for all."
    ),
    level: str = option(
        "-l --level LEVEL",
        "The most talkative level to be printed (default NORMAL).",
        WordChoice("level", LEVELS),
        default="NORMAL",
    ),
    grep: str | None = option("-g --grep TEXT", "Print only what has this in it."),
    since_s: float | None = option(
        "--since SECONDS", "Begin with what was logged in the last SECONDS.", POSITIVE
    ),
    number: int | None = option(
        "-n --number N",
        "Begin with the last N records (default 10; all with --no-follow or --since).",
        click.IntRange(min=0),
    ),
    follow: bool = option(
        "--follow/--no-follow", "Go on with what comes (default), or end.", default=True
    ),
    duration_s: float | None = lasting(),
    is_json: bool = json_flag(),
    paths: tuple[str, ...] = arguments("PATH..."),
) -> None:
    r"""Print what components log.

    PATH is a component; a slave, for all that its process logs; a manager, for its own log and
    those of its slaves; or a directory, for the components in it; / for everything. What is there
    comes first, then what is logged, in the order of time. Zombies, and components of a manager
    that does not run, have logs too.

    \b
    levels   FATAL ERROR WARN INFO NORMAL DEBUG TRACE VERBOSE PARANOID
    sources  of a component its name; else rtkit, stdout, stderr or the name of a logger

    \b
    What code of a component prints, or logs elsewhere, bears its name: while it is imported,
    made or called, and on threads that it starts. After a crash the stacks are printed, too,
    also of one that ended its manager. What C code and programs print is in NAME.out beside.

    What a component does not log at its level (option logger.log_level) cannot be printed.
    """
    if not paths:
        raise WrongArguments("No component specified.")
    app.bound(duration_s)
    is_meant, unlogged = _about(app, paths)
    wanted = all_of(is_meant, selected(level, sources, grep, since_s))
    is_tail = follow and since_s is None
    before = number if number is not None else _BEFORE if is_tail else None
    show = _json if is_json else _text
    until = None if duration_s is None else time.monotonic() + duration_s
    with closing(pieces(app, wanted, before, until, is_over=not follow, unlogged=unlogged)) as read:
        for piece in read:
            terminal.write_now([line for entry in piece for line in show(entry)])


def _about(app: App, typed: Sequence[str]) -> tuple[Wanted, list[LogEntry]]:
    """Return whether a record is about one of the paths, and records that are in no log yet."""
    from rtkit.tree.place import check_is_here

    read = [app.path(each) for each in typed]
    for path in read:
        if path.port is not None:
            raise Malformed(f"Not a component: {path.typed}")
        check_is_here(path, "logs are read")
    unlogged: list[LogEntry] = []
    try:
        tests = [about(app, path) for path in read]
    except Unreachable as error:
        from rtkit.cli.observing.unseen import unseen_entries

        app.fail(f"{error}; logs are looked for by name")
        tests = [about_name(path) for path in read]
        unlogged = list(unseen_entries(app.manager))
    return lambda entry: any(test(entry) for test in tests), unlogged


def _text(entry: LogEntry) -> list[str]:
    from datetime import datetime

    from rtkit.cli.shared.terminal import clock

    who = entry.component or entry.process
    head = f"[{who} {clock(datetime.fromisoformat(entry.time).timestamp())}] "
    first, *others = entry.message.split("\n")
    rest = f" <{entry.source}> {first}"
    level = terminal.styled(f"{entry.level:<5}", _STYLES.get(entry.level))
    more = [*others, *entry.exception.splitlines()]
    printable = terminal.printable
    return [printable(head) + level + printable(rest), *(f"    {printable(each)}" for each in more)]


def _json(entry: LogEntry) -> list[str]:
    from rtkit.cli.shared.json_records import line

    manager = entry.file.removesuffix(f".{entry.process}")
    fields = {**entry._asdict(), "manager": manager, "time": f"{entry.time[:-1]}000Z"}
    del fields["file"]
    return [line("log-record", fields)]
