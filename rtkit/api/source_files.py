"""Watches source files by looking at them, and tells which have been saved.

A look at a file costs a few microseconds, needs no package, and sees what other hosts write into a
shared folder.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from contextlib import suppress

PERIOD_S = 0.2
"""How often to look [s]."""
_ABSENCES = 5
"""Looks for which a file may be missing while an editor puts another one in its place."""
_NEIGHBOURS = (".py", ".idl", ".xml", ".yaml")

Stamp = tuple[int, int, int]


def stamp_of(file: str) -> Stamp | None:
    """Return what changes with a file; None where there is none."""
    with suppress(OSError):
        status = os.stat(file)
        return status.st_ino, status.st_size, status.st_mtime_ns
    return None


class SourceFiles:
    """Files that are watched, and the sources beside them.

    A file counts as saved when two looks find the same: an editor may truncate it and write it, or
    move another one in its place.
    """

    def __init__(self, stamp: Callable[[str], Stamp | None] = stamp_of) -> None:
        self._stamp = stamp
        self._files: frozenset[str] = frozenset()
        self._known: dict[str, Stamp | None] = {}
        self._last: dict[str, Stamp | None] = {}
        self._missing: dict[str, int] = {}

    def follow(self, files: Iterable[str]) -> None:
        """Watch these files, and sources beside them; what was changed already is still told."""
        self._files = frozenset(map(os.path.abspath, files))
        present = self._present()
        self._known = {file: self._known.get(file, stamp) for file, stamp in present.items()}
        self._last = present

    def saved(self) -> list[str]:
        """Return the files that were saved since the last call, or have gone."""
        now = self._present()
        is_settled, self._last = now == self._last, now
        if not is_settled:
            return []
        found = [file for file in now if now[file] != self._known.get(file)]
        for file in found:
            if now[file] is None and self._missing.setdefault(file, _ABSENCES):
                self._missing[file] -= 1
                return []
        self._missing.clear()
        self._known = now
        return sorted(found)

    def _present(self) -> dict[str, Stamp | None]:
        folders = {os.path.dirname(file) for file in self._files if file.endswith(_NEIGHBOURS)}
        beside: set[str] = set()
        for folder in folders:
            with suppress(OSError):
                beside.update(
                    os.path.join(folder, name)
                    for name in os.listdir(folder)
                    if name.endswith(_NEIGHBOURS) and not name.startswith(".")
                )
        return {file: self._stamp(file) for file in self._files | beside}
