"""Finds modules: by name inside the load paths, by absolute path where that is allowed.

A name leads to no other place: neither by ``..`` nor by a link. What is checked is what is read.
One that no load path has may be that of a module of an installed package: as that package names
it for components or, where absolute paths are allowed, as Python does (``robot.arm``).
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rtkit.errors import NotFound, Refused
from rtkit.modules.installed import file_of, installed
from rtkit.settings.reading import find_private

SUFFIX = ".py"


class ModuleSource(NamedTuple):
    """A module as it was read.

    Attributes:
        real: Where the file is, without links.
        init: Name of its init function where its package names one; else empty.
    """

    file: str
    real: str
    text: bytes
    init: str = ""


class _Place(NamedTuple):
    """Location of a module: its file, the load path that it has to be in, if any, and its init."""

    file: str = ""
    folder: str = ""
    init: str = ""


class Search:
    """Searches for modules in load paths."""

    def __init__(self, folders: Sequence[str], *, is_absolute_allowed: bool = True) -> None:
        self.folders = tuple(folders)
        self._is_absolute_allowed = is_absolute_allowed

    def read(self, path: str) -> ModuleSource:
        """Find a module and read it.

        Raises:
            NotFound: There is no such file.
            Refused: It lies where no module is taken from; names the rule.
        """
        file, folder, init = self._place(path)
        if not file or not os.path.isfile(file):
            looked = f"looked in {', '.join(self.folders)} and among installed packages"
            raise NotFound(f"no module {path} ({looked})")
        text, real = find_private(file)
        if folder and not _is_inside(real, os.path.realpath(folder)):
            raise Refused(f"module {path} is a link that leaves the load path {folder}")
        return ModuleSource(file, real, text, init)

    def has(self, path: str) -> bool:
        """Return whether there is a module of that name."""
        return bool(self._find(path).file)

    def modules(self) -> Iterator[str]:
        """Yield the names of what could be modules, each once, as it would be found."""
        seen = set()
        for folder in self.folders:
            try:
                names = sorted(os.listdir(folder))
            except OSError:
                continue
            for name in names:
                if name.endswith(SUFFIX) and not name.startswith(".") and name not in seen:
                    seen.add(name)
                    yield name
        for name in installed():
            if f"{name}{SUFFIX}" not in seen:
                yield f"{name}{SUFFIX}"

    def _place(self, path: str) -> _Place:
        if not os.path.isabs(path):
            if ".." in path.split("/"):
                raise Refused(f"module path leaves the load paths: {path}")
            return self._find(path)
        plain = os.path.normpath(path)
        for folder in self.folders:
            if _is_inside(plain, os.path.normpath(folder)):
                return _Place(plain, "" if self._is_absolute_allowed else folder)
        if not self._is_absolute_allowed:
            raise Refused(
                "absolute module paths are not allowed here"
                f" (manager.modules.abs_path_allowed is NO): {path}"
            )
        return _Place(plain)

    def _find(self, path: str) -> _Place:
        for name in (path, f"{path}{SUFFIX}"):
            for folder in self.folders:
                file = os.path.join(folder, name)
                if os.path.isfile(file):
                    return _Place(file, folder)
        known = installed().get(path.removesuffix(SUFFIX))
        if known is not None:
            return _Place(known.file, init=known.init)
        is_dotted = "." in path and all(part.isidentifier() for part in path.split("."))
        return _Place(file_of(path) if is_dotted and self._is_absolute_allowed else "")


def _is_inside(path: str, folder: str) -> bool:
    return path.startswith(folder.rstrip("/") + "/")
