"""``rtvlog``: print what components log."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING

import click

from rtkit.api.logs import LEVELS, FarLogs, about, about_name, is_far, pieces
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
from rtkit.errors import Malformed, RtkitError, Unreachable
from rtkit.logs.selection import About, Selection

if TYPE_CHECKING:
    from rtkit.logs.logbook import LogEntry
    from rtkit.tree.client import Tree

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
) -> int:
    r"""Print what components log.

    PATH is a component; a slave, for all that its process logs; a manager, for its own log and
    those of its slaves; or a directory, for the components in it; / for everything. Records that
    are there come first, then new ones, in the order of time. PATHs may be on several hosts, / is
    all linked ones, too: the offsets of their clocks are told, and taken off their times. Zombies,
    and components of a manager that does not run, have logs too.

    \b
    levels   FATAL ERROR WARN INFO NORMAL DEBUG TRACE VERBOSE PARANOID
    sources  of a component its name; else rtkit, stdout, stderr or the name of a logger

    \b
    What code of a component prints, or logs elsewhere, bears its name: while it is imported,
    made or called, and on threads that it starts. After a crash the stacks are printed, too,
    also of one that ended its manager. The output of C code and programs is in NAME.out beside.

    Records below the level of a component (option logger.log_level) cannot be printed.
    """
    if not paths:
        raise WrongArguments("No component specified.")
    app.bound(duration_s)
    Selection(level).wanted()  # which tells whether there is such a level
    near, unlogged, far, failed = _about(app, paths)
    chosen = Selection(level, sources, grep, since_s)
    selection = chosen._replace(about=tuple(near)) if near else None
    there = [FarLogs(tree, chosen._replace(about=tuple(each))) for tree, each in far.items()]
    is_tail = follow and since_s is None
    before = number if number is not None else _BEFORE if is_tail else None
    show = _json if is_json else partial(_text, is_named=bool(far))
    until = None if duration_s is None else time.monotonic() + duration_s
    read = pieces(app, selection, before, until, is_over=not follow, unlogged=unlogged, far=there)
    with closing(read):
        for piece in read:
            terminal.write_now([line for entry in piece for line in show(entry)])
    return failed


Far = dict["Tree", list[About]]


def _about(app: App, typed: Sequence[str]) -> tuple[list[About], list[LogEntry], Far, int]:
    """Return what of this host and of others paths name, and records that are in no log yet.

    The last is the exit status for hosts that cannot be reached.
    """
    from rtkit.tree.place import is_on_another_host

    near: list[About] = []
    unlogged: list[LogEntry] = []
    far: Far = {}
    failed = 0
    for path in [app.beside(each) for each in typed]:
        if path.port is not None:
            raise Malformed(f"Not a component: {path.typed}")
        try:
            tree = app.tree_at(path)
            (far.setdefault(tree, []) if is_far(tree) else near).append(about(tree, path))
            is_everything = not path.elements and not is_far(tree)
        except Unreachable as error:
            if is_on_another_host(path):
                raise
            from rtkit.cli.observing.unseen import unseen_entries

            app.fail(f"{error}; logs are looked for by name")
            near.append(about_name(path))
            unlogged += [] if unlogged else unseen_entries(app.manager)
            is_everything = not path.elements
        failed |= is_everything and _add_linked(app, far)
    return near, unlogged, far, failed


def _add_linked(app: App, far: Far) -> int:
    """Add all of each linked host; return 1 if one cannot be reached."""
    from rtkit.link.host_links import hosts

    status = 0
    for host in hosts():
        try:
            tree = app.tree_at(app.beside(f"/{host}"))
            tree.get("manager.pid")
        except RtkitError as error:
            app.fail(str(error))
            status = 1
        else:
            far.setdefault(tree, []).append(About())
    return status


def _text(entry: LogEntry, *, is_named: bool) -> list[str]:
    from datetime import datetime

    from rtkit.cli.shared.terminal import clock
    from rtkit.rtc.names import LOCAL

    who = entry.component or entry.process
    who = f"{entry.host or LOCAL}/{who}" if is_named else who
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
    fields["host"] = entry.host or "localhost"
    del fields["file"]
    return [line("log-record", fields)]
