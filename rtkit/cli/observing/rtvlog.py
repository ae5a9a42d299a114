"""``rtvlog``: print what components log."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import click

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
from rtkit.cli.shared.stdout_reader import wait_for
from rtkit.errors import Malformed, Unreachable

if TYPE_CHECKING:
    from rtkit.rtc.names import Path
    from rtkit.tree.logbook import LogEntry, Wanted

LEVELS = ("FATAL", "ERROR", "WARN", "INFO", "NORMAL", "DEBUG", "TRACE", "VERBOSE", "PARANOID")
"""From few words to many; NORMAL is what a component says that is told nothing else."""

_BEFORE = 10
_SETTLE_S = 0.02
"""Wait for simultaneous records of other processes, so that they can be put in order [s]."""

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
    from rtkit.link.places import state_dir
    from rtkit.tree.logbook import Logbook

    if not paths:
        raise WrongArguments("No component specified.")
    app.bound(duration_s)
    about, unlogged = _about(app, paths)
    wanted = _all_of(about, _loud_enough(level), _sent_by(sources), _with(grep), _after(since_s))
    is_tail = follow and since_s is None
    before = number if number is not None else _BEFORE if is_tail else None
    show = _json if is_json else _text
    until = None if duration_s is None else time.monotonic() + duration_s
    logbook = Logbook(state_dir(), wanted)
    try:
        present = logbook.there(before, unlogged)
        terminal.write_now([line for entry in present for line in show(entry)])
        while follow and wait_for([logbook.fileno()], until):
            time.sleep(_SETTLE_S)
            terminal.write_now([line for entry in logbook.delta() for line in show(entry)])
        if logbook.unreadable:
            app.report(f"{app.name}: {logbook.unreadable} lines are no records")
    finally:
        logbook.close()


def _all_of(*conditions: Wanted) -> Wanted:
    return lambda entry: all(holds(entry) for holds in conditions)


def _loud_enough(level: str) -> Wanted:
    words = set(LEVELS[: LEVELS.index(level) + 1])
    return lambda entry: entry.level in words


def _sent_by(sources: Sequence[str]) -> Wanted:
    names = tuple(each.casefold() for each in sources)
    if not names or "all" in names:
        return lambda entry: True

    def is_from_source(entry: LogEntry) -> bool:
        origins = {entry.source.casefold(), entry.component.casefold()}
        return any(one == name or one.startswith(f"{name}.") for one in origins for name in names)

    return is_from_source


def _with(text: str | None) -> Wanted:
    if text is None:
        return lambda entry: True
    return lambda entry: text in entry.message or text in entry.exception


def _after(since_s: float | None) -> Wanted:
    from rtkit.cli.shared.json_records import time_text

    if since_s is None:
        return lambda entry: True
    first = time_text(int((time.time() - since_s) * 1e9))
    return lambda entry: entry.time >= first


def _about(app: App, typed: Sequence[str]) -> tuple[Wanted, list[LogEntry]]:
    """Return whether a record is about one of the paths, and records that are in no log yet."""
    read = [app.path(each) for each in typed]
    for path in read:
        if path.port is not None:
            raise Malformed(f"Not a component: {path.typed}")
    unlogged: list[LogEntry] = []
    try:
        tests = [_about_node(app, path) for path in read]
    except Unreachable as error:
        from rtkit.cli.observing.unseen import unseen_entries

        app.fail(f"{error}; logs are looked for by name")
        tests = [_about_name(path) for path in read]
        unlogged = list(unseen_entries(app.manager))
    return lambda entry: any(test(entry) for test in tests), unlogged


def _about_node(app: App, path: Path) -> Wanted:
    from rtkit.tree.resolve import entry
    from rtkit.tree.view import NodeKind

    root, hostname = app.root(path, is_deep=False)
    node = entry(root, path, hostname)
    manager = app.tree.manager
    if node.instance:
        return _of_components(manager, {node.instance})
    if node.is_slave:
        return _of_file(f"{manager}.{node.process}")
    if node.kind is NodeKind.MANAGER:
        return _of_file(manager, is_deep=True)
    if node.kind is NodeKind.DIRECTORY:
        return _of_components(manager, {each.instance for each in node.walk() if each.instance})
    return lambda entry: True


def _about_name(path: Path) -> Wanted:
    """Return a predicate on the last name of a path, where no manager can be asked."""
    from rtkit.rtc.names import COMPONENT_SUFFIX, MANAGER_SUFFIX

    if len(path.elements) < 2:
        return lambda entry: True
    *_, above, name = path.elements
    if not name.endswith(MANAGER_SUFFIX):
        return _of_components("", {name.removesuffix(COMPONENT_SUFFIX)})
    own = name.removesuffix(MANAGER_SUFFIX)
    if above.endswith(MANAGER_SUFFIX):
        return _of_file(f"{above.removesuffix(MANAGER_SUFFIX)}.{own}")
    return _of_file(own, is_deep=True)


def _of_file(name: str, *, is_deep: bool = False) -> Wanted:
    return lambda entry: entry.file == name or (is_deep and entry.file.startswith(f"{name}."))


def _of_components(manager: str, instances: Iterable[str]) -> Wanted:
    """Return a predicate: whether a record is from components, or loggers below theirs."""
    names = set(instances)
    is_near = _of_file(manager, is_deep=True) if manager else lambda _entry: True

    def is_about(entry: LogEntry) -> bool:
        return (entry.component or entry.source.partition(".")[0]) in names and is_near(entry)

    return is_about


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
