"""Reads the logs of managers and slaves: the present records, then new ones, merged by time.

Each process writes a file of its own, one JSON object a line, and begins it again when it is full.
The logbook reads the files in place, so no writer waits for a reader and no record is missed; the
kernel reports when a file was written.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Container, Iterable, Iterator
from operator import attrgetter
from typing import Any, NamedTuple

from rtkit.link.folder_watch import FolderWatch

_FILE = re.compile(r"(.+)\.log(?:\.(\d+))?")
_CHUNK = 1 << 20


class LogEntry(NamedTuple):
    """One record of a log.

    Attributes:
        time: UTC, ISO 8601; as text it sorts by time.
        file: Name of the log, ``manager.slave``.
        process: Name of the manager or slave that wrote it.
        component: Instance name, if code of a component wrote it.
        source: Name of the logger; that of a component is its instance name.
        host: Where it was logged; empty for this host.
        offset_s: By how much the clock there was ahead, which `time` is put right by [s].
        bound_s: By how much that may be wrong [s].
    """

    time: str
    file: str
    level: str
    process: str
    pid: int
    component: str
    source: str
    message: str
    exception: str
    host: str = ""
    offset_s: float = 0.0
    bound_s: float = 0.0


Wanted = Callable[[LogEntry], bool]


class _File:
    """One log, as far as it has been read."""

    def __init__(self, path: str, name: str) -> None:
        self.path = path
        self.name = name
        self._descriptor = -1
        self._rest = b""

    def read(self) -> Iterator[bytes]:
        """Yield the lines that were not read yet, also those that were moved on meanwhile."""
        yield from self._read_open()
        if self._descriptor < 0 or self._is_other():
            self.close()
            try:
                self._descriptor = os.open(self.path, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
            except OSError:
                return
            yield from self._read_open()

    @property
    def identity(self) -> tuple[int, int]:
        """Device and number of the file that is open; zeros without one."""
        if self._descriptor < 0:
            return 0, 0
        status = os.fstat(self._descriptor)
        return status.st_dev, status.st_ino

    def close(self) -> None:
        """Let go of the file."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor, self._rest = -1, b""

    def _read_open(self) -> Iterator[bytes]:
        while self._descriptor >= 0 and (data := os.read(self._descriptor, _CHUNK)):
            *lines, self._rest = (self._rest + data).split(b"\n")
            yield from lines
            if len(self._rest) > _CHUNK:  # no line of ours is that long
                self._rest = b""

    def _is_other(self) -> bool:
        """Return whether another file lies at the path now."""
        try:
            there = os.stat(self.path, follow_symlinks=False)
        except OSError:
            return True
        return (there.st_dev, there.st_ino) != self.identity


class Logbook:
    """The logs of one folder.

    Attributes:
        unreadable: How many lines were no records.
    """

    def __init__(self, folder: str, wanted: Wanted, files: Container[str] | None = None) -> None:
        """Begin to listen, so that nothing is missed between what is there and what comes.

        With `files`, names of logs, no other one is read at the beginning.

        Raises:
            Refused: The folder is not there.
        """
        self._folder = folder
        self._wanted = wanted
        self._wanted_files = files
        self._subscription = FolderWatch(folder)
        self._files: dict[str, _File] = {}
        self.unreadable = 0

    def fileno(self) -> int:
        """Return the descriptor that turns readable when something was written."""
        return self._subscription.fileno()

    def close(self) -> None:
        """Read no more."""
        self._subscription.close()
        for file in self._files.values():
            file.close()

    def there(self, most: int | None = None, others: Iterable[LogEntry] = ()) -> list[LogEntry]:
        """Return what is in the logs, or of that the latest, and have `delta` begin after it.

        Records of `others` that are wanted are put among them.
        """
        entries: list[LogEntry] = list(filter(self._wanted, others))
        seen: set[tuple[int, int]] = set()
        for name, number in self._names():
            file = _File(os.path.join(self._folder, name), name.rpartition(".log")[0])
            read = list(self._entries(file))
            if file.identity not in seen:  # else it was moved on while it was being read
                entries += read
                seen.add(file.identity)
            if number == 0:
                self._files[name] = file
            else:
                file.close()
        entries.sort(key=attrgetter("time"))
        return entries if most is None else entries[max(0, len(entries) - most) :]

    def delta(self) -> list[LogEntry]:
        """Return what was written since the last time."""
        entries: list[LogEntry] = []
        for name in sorted(self._subscription.take()):
            match = _FILE.fullmatch(name)
            if match is None or match[2]:
                continue
            if name not in self._files:
                self._files[name] = _File(os.path.join(self._folder, name), match[1])
            entries += self._entries(self._files[name])
        return sorted(entries, key=attrgetter("time"))

    def news(self) -> list[str]:
        """Return what else is to be told: nothing."""
        return []

    def _names(self) -> list[tuple[str, int]]:
        """Return the files there are, the present ones of all logs first."""
        found = [(name, _FILE.fullmatch(name)) for name in os.listdir(self._folder)]
        named = [
            (name, int(match[2] or 0))
            for name, match in found
            if match is not None and (self._wanted_files is None or match[1] in self._wanted_files)
        ]
        return sorted(named, key=lambda each: (each[1], each[0]))

    def _entries(self, file: _File) -> Iterator[LogEntry]:
        for line in file.read():
            entry = _entry(file.name, line)
            if entry is None:
                self.unreadable += bool(line.strip())
            elif self._wanted(entry):
                yield entry


def _entry(file: str, line: bytes) -> LogEntry | None:
    """Return the record of a line; None when it is none, as after a full disk."""
    try:
        fields: Any = json.loads(line)
        component = str(fields.get("component", ""))
        return LogEntry(
            str(fields["time"]),
            file,
            str(fields["level"]),
            str(fields["process"]),
            int(fields["pid"]),
            component,
            str(fields.get("logger") or component or fields["logger"]),
            str(fields["message"]),
            str(fields.get("exception", "")),
        )
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
