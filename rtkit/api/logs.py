"""Logs of components and processes: which records are wanted, those there are, those that come."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterable, Sequence
from contextlib import closing
from typing import TYPE_CHECKING

from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.rtc.names import Path
    from rtkit.tree.logbook import LogEntry, Wanted

LEVELS = ("FATAL", "ERROR", "WARN", "INFO", "NORMAL", "DEBUG", "TRACE", "VERBOSE", "PARANOID")
"""From few words to many; NORMAL is what a component says that is told nothing else."""

_SETTLE_S = 0.02
"""Wait for simultaneous records of other processes, so that they can be put in order [s]."""


def selected(
    level: str = "NORMAL",
    sources: Sequence[str] = (),
    text: str | None = None,
    since_s: float | None = None,
) -> Wanted:
    """Return a predicate on records, whatever they are about; see `rtkit.Tree.logs`.

    Raises:
        Malformed: There is no such level.
    """
    if level not in LEVELS:
        raise Malformed(f"no such level: {level} (one of {', '.join(LEVELS)})")
    return all_of(_loud_enough(level), _sent_by(sources), _with(text), _after(since_s))


def pieces(
    session: Session,
    wanted: Wanted,
    last: int | None,
    until: float | None,
    *,
    is_over: bool,
    unlogged: Sequence[LogEntry] = (),
) -> Generator[list[LogEntry], None, None]:
    """Yield the records there are, then unless it `is_over` those that come, together what is.

    Args:
        session: Of whoever reads; lines that are no records are reported to it.
        wanted: Which records.
        last: How many of those that are there; None for all.
        until: When to end, monotonic [s]; None for never.
        is_over: End after those that are there.
        unlogged: Records that are in no log yet.
    """
    from rtkit.link.places import state_dir
    from rtkit.tree.logbook import Logbook

    logbook = Logbook(state_dir(), wanted)
    try:
        yield logbook.there(last, unlogged)
        while not is_over and session.wait_for([logbook.fileno()], until):
            time.sleep(_SETTLE_S)
            yield logbook.delta()
        if logbook.unreadable:
            session.fail(f"{logbook.unreadable} lines are no records")
    finally:
        logbook.close()


def follow(
    session: Session, wanted: Wanted, last: int | None, until: float | None, *, is_over: bool
) -> Generator[LogEntry | None, None, None]:
    """Yield None when ready, then records one by one; see `pieces`."""
    with closing(pieces(session, wanted, last, until, is_over=is_over)) as read:
        present = next(read)
        yield None
        yield from present
        for piece in read:
            yield from piece


def all_of(*conditions: Wanted) -> Wanted:
    """Return a predicate: whether all of these hold."""
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
    if since_s is None:
        return lambda entry: True
    from datetime import UTC, datetime

    moment = datetime.fromtimestamp(time.time() - since_s, UTC)
    first = f"{moment:%Y-%m-%dT%H:%M:%S.%f}"
    return lambda entry: entry.time >= first


def about(session: Session, path: Path) -> Wanted:
    """Return a predicate: whether a record is about what a path names.

    Raises:
        NotFound: Nothing is there.
        Unreachable: The manager cannot be asked.
    """
    from rtkit.tree.resolve import entry
    from rtkit.tree.view import NodeKind

    root, hostname = session.root(path, is_deep=False)
    node = entry(root, path, hostname)
    manager = session.tree.manager
    if node.instance:
        return _of_components(manager, {node.instance})
    if node.is_slave:
        return _of_file(f"{manager}.{node.process}")
    if node.kind is NodeKind.MANAGER:
        return _of_file(manager, is_deep=True)
    if node.kind is NodeKind.DIRECTORY:
        return _of_components(manager, {each.instance for each in node.walk() if each.instance})
    return lambda entry: True


def about_name(path: Path) -> Wanted:
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
