"""Checkpoints of slaves: files for a manager whose slave hangs or is dead.

A file of lines, one for each component as it last was and one for each that ended. It is opened
anew for each line, because components may close descriptors that are not theirs.

See decision 41.
"""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Mapping
from typing import Any, NamedTuple

from rtkit.link.places import of_pid

SUFFIX = ".held"
_SLACK = 64 * 1024
_MOST = 4
"""How many times as long as its contents the file may get, beside some slack."""

_log = logging.getLogger(__name__)
_to_json = json.JSONEncoder(separators=(",", ":")).encode


class SlaveCheckpoint(NamedTuple):
    """Checkpoint of a slave: the facts of its components, as the slave would report them."""

    name: str
    components: list[Any]


class CheckpointWriter:
    """Writes the checkpoint file of a slave."""

    def __init__(self, path: str, name: str) -> None:
        self._path = path
        self._first = _line({"slave": name})
        self._lines: dict[str, bytes] = {}
        self._live_size = 0
        self._size = len(self._first)
        self._is_failing = False
        self._write(path, self._first, os.O_CREAT | os.O_TRUNC)

    def keep(self, instance: str, facts: Mapping[str, Any]) -> None:
        """Write down a component as it is now."""
        line = _line(facts)
        before = self._lines.get(instance, b"")
        if line == before:
            return
        self._lines[instance] = line
        self._live_size += len(line) - len(before)
        self._append(line)

    def strike(self, instance: str) -> None:
        """Write down that a component is no more."""
        line = self._lines.pop(instance, None)
        if line is not None:
            self._live_size -= len(line)
            self._append(_line({"gone": instance}))

    def _append(self, line: bytes) -> None:
        self._size += len(line)
        if self._size > _SLACK + _MOST * self._live_size:
            self._rewrite()
        else:
            self._write(self._path, line, os.O_APPEND)

    def _rewrite(self) -> None:
        text = b"".join([self._first, *self._lines.values()])
        self._size = len(text)
        draft = f"{self._path}.new"
        if self._write(draft, text, os.O_CREAT | os.O_TRUNC):
            os.replace(draft, self._path)

    def _write(self, path: str, text: bytes, flags: int) -> bool:
        try:
            descriptor = os.open(path, os.O_WRONLY | os.O_NOFOLLOW | os.O_CLOEXEC | flags, 0o600)
            try:
                os.write(descriptor, text)
            finally:
                os.close(descriptor)
        except OSError as error:
            if not self._is_failing:
                _log.warning("cannot write down what is held here: %s", error)
            self._is_failing = True
            return False
        self._is_failing = False
        return True


def checkpoint_path(pattern: str, pid: int) -> str:
    """Return the path of a slave's checkpoint; `pattern` is that of its data socket."""
    return of_pid(pattern, pid).removesuffix(".data") + SUFFIX


def read_checkpoint(path: str) -> SlaveCheckpoint | None:
    """Return the contents of a checkpoint; None if there is none, or nothing in it."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            lines = file.read().splitlines()
        first = json.loads(lines[0])["slave"]
    except (OSError, ValueError, LookupError, TypeError):
        return None
    held: dict[str, Any] = {}
    for line in lines[1:]:
        try:
            record = json.loads(line)
            if "gone" in record:
                held.pop(record["gone"], None)
            else:
                held[record["instance"]] = record
        except (ValueError, LookupError, TypeError):
            continue  # its slave was killed while it wrote
    return SlaveCheckpoint(str(first), list(held.values()))


def _line(record: Mapping[str, Any]) -> bytes:
    return _to_json(record).encode() + b"\n"
