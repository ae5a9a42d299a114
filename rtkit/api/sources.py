"""Sources of components: checked before a system changes, and watched while one works.

A look at a file costs a few microseconds, needs no package, and sees what other hosts write into a
shared folder.
"""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from typing import TYPE_CHECKING

from rtkit.errors import Refused

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts

PERIOD_S = 0.2
"""How often to look [s]."""
_ABSENCES = 5
"""Looks for which a file may be missing while an editor puts another one in its place."""
_NEIGHBOURS = (".py", ".idl", ".xml", ".yaml")

_IMPORT_S = 60.0
"""How long the import of a module may take [s]."""
_IMPORT = """
import sys
from rtkit.errors import RtkitError
from rtkit.modules.loader import Loader
try:
    Loader([]).load(*sys.argv[1:])
except RtkitError as error:
    sys.exit(str(error))
"""

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
        for folder in folders | {os.path.join(folder, "idl") for folder in folders}:
            with suppress(OSError):
                beside.update(
                    os.path.join(folder, name)
                    for name in os.listdir(folder)
                    if name.endswith(_NEIGHBOURS) and not name.startswith(".")
                )
        return {file: self._stamp(file) for file in self._files | beside}


def syntax_errors(files: Iterable[str]) -> Iterator[str]:
    """Yield ``FILE:LINE: SyntaxError: text`` for each Python file that does not compile."""
    for file in files:
        try:
            with open(file, "rb") as stream, warnings.catch_warnings():
                warnings.simplefilter("ignore")
                compile(stream.read(), file, "exec", dont_inherit=True)
        except SyntaxError as error:
            yield f"{shown(file)}:{error.lineno or 1}: {type(error).__name__}: {error.msg}"
        except (OSError, ValueError) as error:
            yield f"{shown(file)}:1: {error}"


def shown(file: str) -> str:
    """Return a file as users of the working directory call it."""
    relative = os.path.relpath(file)
    return file if relative.startswith("..") else relative


def files_of(components: Iterable[ComponentFacts]) -> list[str]:
    """Return the files that components come from, each module before what it imports."""
    lines = (line for facts in components for line in facts.code.splitlines())
    return list(dict.fromkeys(line.partition(" ")[2] for line in lines))


def check_imports(modules: Iterable[tuple[str, str]]) -> None:
    """Import modules, each by file and init function, in a process of its own.

    Raises:
        Refused: One does not import, or its init function fails; says where.
    """
    for file, init in dict.fromkeys(modules):
        command = [sys.executable, "-c", _IMPORT, file, init]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=_IMPORT_S, check=False
            )
        except subprocess.TimeoutExpired:
            raise Refused(f"{shown(file)}: its import takes longer than {_IMPORT_S:g} s") from None
        if done.returncode:
            lines = done.stderr.strip().splitlines()
            raise Refused(lines[-1] if lines else f"{shown(file)}: exit status {done.returncode}")
