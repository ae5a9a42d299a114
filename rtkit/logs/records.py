"""Formats log records: one JSON object a line for the file, one readable line for a terminal.

Neither ever holds a control character that came with a message: what would steer a terminal, end
a line or hide text is written as an escape.
"""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Container

from rtkit.component.current import current

MAX_TEXT = 32_768
"""Characters of a message, or of an exception, that are kept."""

LEVELS = {
    "SILENT": logging.CRITICAL + 1,
    "FATAL": logging.CRITICAL,
    "ERROR": logging.ERROR,
    "WARN": logging.WARNING,
    "INFO": logging.INFO,
    "DEBUG": logging.DEBUG,
    "TRACE": 8,
    "VERBOSE": 6,
    "PARANOID": 4,
}
"""Least levels that are logged, by the words of ``logger.log_level``; SILENT logs nothing."""

_to_json = json.JSONEncoder(ensure_ascii=False).encode
_WORDS = tuple((number, word) for word, number in LEVELS.items() if word != "SILENT")


def level_word(number: int) -> str:
    """Return the word of a level: of the highest one that is not above it."""
    return next((word for least, word in _WORDS if number >= least), "PARANOID")


class JsonLines(logging.Formatter):
    """Records as JSON objects, one a line.

    Keys: ``time`` (UTC, ISO 8601), ``level``, ``process``, ``pid``, ``component`` for what an
    instance logs, ``logger`` for what any other logger does, ``message``, and ``exception`` if
    there is one. What another logger does while code of a component runs has both: so do lines
    that it prints, and what a manager logs about a component (`extra={"about": instance}`).

    Args:
        process: Name of the manager or slave.
        components: The names of those loggers that are of components.
    """

    def __init__(self, process: str, components: Container[str] = ()) -> None:
        super().__init__()
        self.process = process
        self._components = components

    def format(self, record: logging.LogRecord) -> str:
        """Return a record's line, without its end."""
        whole, part = divmod(record.created, 1)
        moment = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(whole))
        is_component = record.name in self._components
        instance = record.name if is_component else getattr(record, "about", "") or current.get()
        fields = {
            "time": f"{moment}.{int(part * 1e6):06}Z",
            "level": level_word(record.levelno),
            "process": self.process,
            "pid": record.process,
            **({"component": instance} if instance else {}),
            **({} if is_component else {"logger": record.name}),
            "message": _cut(_message(record)),
        }
        exception = _exception(self, record)
        if exception:
            fields["exception"] = _cut(exception)
        line = _to_json(fields)
        if line.isprintable():
            return line
        return "".join(c if c.isprintable() else json.dumps(c)[1:-1] for c in line)


_PLAIN = "\x1b[0m"
_COLOURS = {
    "FATAL": "\x1b[1;37;41m",
    "ERROR": "\x1b[1;31m",
    "WARN": "\x1b[33m",
    "DEBUG": "\x1b[2m",
    "TRACE": "\x1b[2m",
    "VERBOSE": "\x1b[2m",
    "PARANOID": "\x1b[2m",
}


class Readable(logging.Formatter):
    """Records for people: ``12:30:00.250 INFO  Out0: received 1``, exceptions below, indented.

    Args:
        process: Put before the source, where several processes write to one place.
        date_format: Of `strftime`; by default the time of day with milliseconds.
        is_coloured: Show by colour what is more, or less, than usual.
    """

    def __init__(
        self, process: str = "", date_format: str = "", *, is_coloured: bool = False
    ) -> None:
        super().__init__()
        self.process = process
        self._date_format = date_format
        self._is_coloured = is_coloured

    def format(self, record: logging.LogRecord) -> str:
        """Return a record's lines, without the end of the last one."""
        moment = time.strftime(self._date_format or "%H:%M:%S", time.localtime(record.created))
        part = "" if self._date_format else f".{int(record.msecs):03}"
        level = level_word(record.levelno)
        prefix = f"{self.process}/" if self.process else ""
        head = f"{moment}{part} {level:<5} {prefix}{record.name}: "
        first, *others = _cut(_message(record)).split("\n")
        others += _cut(_exception(self, record)).splitlines()
        head = printable(head + first)
        colour = _COLOURS.get(level, "") if self._is_coloured else ""
        head = f"{colour}{head}{_PLAIN}" if colour else head
        return "\n".join([head, *(f"    {printable(each)}" for each in others)])


def printable(text: str) -> str:
    """Return `text` with everything that is no visible character or blank as an escape."""
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text
    )


def _message(record: logging.LogRecord) -> str:
    try:
        return record.getMessage()
    except Exception as error:
        try:
            return f"{record.msg!r} % {record.args!r} ({type(error).__name__}: {error})"
        except Exception:
            return f"(a message that cannot be shown, from {record.pathname}:{record.lineno})"


def _exception(formatter: logging.Formatter, record: logging.LogRecord) -> str:
    parts = []
    if record.exc_info and record.exc_info[1] is not None:
        try:
            parts.append(formatter.formatException(record.exc_info))
        except Exception as error:
            parts.append(f"(an exception that cannot be shown: {type(error).__name__})")
    if record.stack_info:
        parts.append(record.stack_info)
    return "\n".join(parts)


def _cut(text: str) -> str:
    return text if len(text) <= MAX_TEXT else text[: MAX_TEXT - 1] + "…"
