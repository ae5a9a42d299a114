"""Selection of log records: level, source, text, age, and subject; sent as JSON, too."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from rtkit.errors import Malformed
from rtkit.logs.logbook import LogEntry, Wanted

LEVELS = ("FATAL", "ERROR", "WARN", "INFO", "NORMAL", "DEBUG", "TRACE", "VERBOSE", "PARANOID")
"""From few words to many; NORMAL is what a component says that is told nothing else."""

LOGS = "logs"
"""Extension of a manager, and its topic, by which other hosts get the records."""


class About(NamedTuple):
    """Subject of records; everything, if nothing is set.

    Attributes:
        file: Name of a log, ``manager.slave``; empty for all.
        is_deep: Logs of its slaves, too.
        instances: Only records of these components, or loggers below theirs.
    """

    file: str = ""
    is_deep: bool = False
    instances: tuple[str, ...] | None = None

    def covers(self, entry: LogEntry) -> bool:
        """Return whether a record is about it."""
        is_in = not self.file or entry.file == self.file
        if not (is_in or (self.is_deep and entry.file.startswith(f"{self.file}."))):
            return False
        if self.instances is None:
            return True
        return (entry.component or entry.source.partition(".")[0]) in self.instances


class Selection(NamedTuple):
    """Records that are wanted.

    Attributes:
        level: The most talkative one.
        sources: Only what these loggers, or those below them, log; all if there are none.
        text: Only what has this in it.
        since_s: Only what was logged in the last seconds [s].
        about: Only what is about one of these.
    """

    level: str = "NORMAL"
    sources: tuple[str, ...] = ()
    text: str | None = None
    since_s: float | None = None
    about: tuple[About, ...] = (About(),)

    def wanted(self) -> Wanted:
        """Return a predicate on records.

        Raises:
            Malformed: There is no such level.
        """
        subjects = self.about
        return all_of(
            _loud_enough(self.level),
            _sent_by(self.sources),
            _with(self.text),
            _after(self.since_s),
            lambda entry: any(each.covers(entry) for each in subjects),
        )


def selection_to_text(selection: Selection, most: int | None, mark: str) -> str:
    """Return a request for records as it is sent to a manager.

    Args:
        selection: Which.
        most: How many of the latest; None for all.
        mark: Sent on the topic of its records before the answer, if it follows its logs.
    """
    return json.dumps({**selection._asdict(), "most": most, "mark": mark})


def selection_from_text(text: str) -> tuple[Selection, int | None, str]:
    """Return what `selection_to_text` was given.

    Raises:
        Malformed: It is no such request.
    """
    try:
        asked: dict[str, Any] = json.loads(text)
        most, since_s, part = asked["most"], asked["since_s"], asked["text"]
        if since_s is not None and not math.isfinite(since_s):
            raise ValueError(f"since {since_s} s")
        selection = Selection(
            str(asked["level"]),
            tuple(map(str, asked["sources"])),
            None if part is None else str(part),
            None if since_s is None else float(since_s),
            tuple(_about(*each) for each in asked["about"]),
        )
        return selection, None if most is None else int(most), str(asked["mark"])
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        raise Malformed(f"no request for log records: {error}") from error


def _about(file: object, is_deep: object, instances: Iterable[object] | None) -> About:
    return About(
        str(file), bool(is_deep), None if instances is None else tuple(map(str, instances))
    )


def all_of(*conditions: Wanted) -> Wanted:
    """Return a predicate: whether all of these hold."""
    return lambda entry: all(holds(entry) for holds in conditions)


def _loud_enough(level: str) -> Wanted:
    if level not in LEVELS:
        raise Malformed(f"no such level: {level} (one of {', '.join(LEVELS)})")
    words = set(LEVELS[: LEVELS.index(level) + 1])
    return lambda entry: entry.level in words


def _sent_by(sources: Iterable[str]) -> Wanted:
    names = tuple(each.casefold() for each in sources)
    if not names or "all" in names:
        return lambda entry: True

    def is_from_source(entry: LogEntry) -> bool:
        origins = {entry.source.casefold(), entry.component.casefold()}
        return any(one == name or one.startswith(f"{name}.") for one in origins for name in names)

    return is_from_source


def _with(text: str | None) -> Callable[[LogEntry], bool]:
    if text is None:
        return lambda entry: True
    return lambda entry: text in entry.message or text in entry.exception


def _after(since_s: float | None) -> Wanted:
    if since_s is None:
        return lambda entry: True
    from datetime import UTC, datetime

    try:
        moment = datetime.fromtimestamp(time.time() - since_s, UTC)
    except (ValueError, OverflowError, OSError):
        return lambda entry: True  # since before there was any
    first = f"{moment:%Y-%m-%dT%H:%M:%S.%f}"
    return lambda entry: entry.time >= first
