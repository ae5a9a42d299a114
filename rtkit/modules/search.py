"""Finds modules: by name inside the load paths, by absolute path where that is allowed.

A name leads to no other place: neither by ``..`` nor by a link. What is checked is what is read.
One that no load path has may be that of a module of an installed package: as that package names
it for components or, where absolute paths are allowed, as Python does (``robot.arm``). Packages
declare entry points of the group ``rtkit.components``, ``NAME = MODULE:INIT``: the module is
requested by NAME, usually the name of its component type, or by MODULE. None of them is run to be
found.
"""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from typing import NamedTuple

from rtkit.errors import NotFound, Refused
from rtkit.rtc.nearest import did_you_mean
from rtkit.settings.reading import find_private

SUFFIX = ".py"


class ModuleSource(NamedTuple):
    """A module as it was read.

    Attributes:
        real: Where the file is, without links.
        init: Name of its init function where its package names one; else empty.
        package: Name of the package that it is part of, as Python imports it; else empty.
        path: By which it is found again wherever its package is installed; else as it was asked.
    """

    file: str
    real: str
    text: bytes
    init: str = ""
    package: str = ""
    path: str = ""


class ModulePlace(NamedTuple):
    """Location of a module: file, load path that it has to be in, if any, init and package."""

    file: str = ""
    folder: str = ""
    init: str = ""
    package: str = ""

    @property
    def name(self) -> str:
        """The name by which Python knows it."""
        stem = os.path.basename(self.file).removesuffix(SUFFIX)
        return f"{self.package}.{stem}" if self.package else stem


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
        place = self._place(path)
        file, folder, init, package = place
        if not file or not os.path.isfile(file):
            looked = f"looked in {', '.join(self.folders)} and among installed packages"
            known = [each.removesuffix(SUFFIX) for each in self.modules()]
            if "/" not in path:
                known += [each.name for each in installed().values() if each.package]
            hint = did_you_mean(os.path.basename(path).removesuffix(SUFFIX), known)
            raise NotFound(f"no module {path}{hint} ({looked})")
        text, real = find_private(file)
        if folder and not _is_inside(real, os.path.realpath(folder)):
            raise Refused(f"module {path} is a link that leaves the load path {folder}")
        again = place.name if init and package else path  # a file elsewhere may be called so, too
        return ModuleSource(file, real, text, init, package or package_of(file), again)

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

    def _place(self, path: str) -> ModulePlace:
        if not os.path.isabs(path):
            if ".." in path.split("/"):
                raise Refused(f"module path leaves the load paths: {path}")
            return self._find(path)
        plain = os.path.normpath(path)
        for folder in self.folders:
            if _is_inside(plain, os.path.normpath(folder)):
                return ModulePlace(plain, "" if self._is_absolute_allowed else folder)
        if not self._is_absolute_allowed:
            raise Refused(
                "absolute module paths are not allowed here"
                f" (manager.modules.abs_path_allowed is NO): {path}"
            )
        return ModulePlace(plain)

    def _find(self, path: str) -> ModulePlace:
        for name in (path, f"{path}{SUFFIX}"):
            for folder in self.folders:
                file = os.path.join(folder, name)
                if os.path.isfile(file):
                    return ModulePlace(file, folder)
        there = installed()
        known = there.get(path.removesuffix(SUFFIX))
        if known is not None:
            return known
        if "." not in path or not all(part.isidentifier() for part in path.split(".")):
            return ModulePlace()
        package = path.rpartition(".")[0]
        for folder in self.folders:
            file = f"{os.path.join(folder, *path.split('.'))}{SUFFIX}"
            if os.path.isfile(file):
                return ModulePlace(file, folder, package=package)
        is_allowed = self._is_absolute_allowed or any(path == each.name for each in there.values())
        return ModulePlace(file_of(path) if is_allowed else "", package=package)


def _is_inside(path: str, folder: str) -> bool:
    return path.startswith(folder.rstrip("/") + "/")


GROUP = "rtkit.components"
_METADATA = (".dist-info", ".egg-info")
_SECTION = re.compile(r"\s*\[(.*)\]\s*")
_ENTRY = re.compile(r"\s*([^=#;\s][^=]*?)\s*=\s*([\w.]+)\s*:\s*(\w+)\s*(?:\[.*\])?\s*")
_LARGEST = 1 << 20


def installed() -> dict[str, ModulePlace]:
    """Return the modules of all packages that Python finds here, by name; the first one counts."""
    importlib.invalidate_caches()
    found: dict[str, ModulePlace] = {}
    for folder in dict.fromkeys(sys.path):
        for name, module, init in _entries(folder):
            file = "" if name in found else file_of(module)
            if file:
                found[name] = ModulePlace(file, init=init, package=module.rpartition(".")[0])
    return found


def _entries(folder: str) -> Iterator[tuple[str, str, str]]:
    """Yield name, module and init function of each entry point of the packages in a folder."""
    try:
        names = sorted(os.listdir(folder or "."))
    except OSError:
        return
    for name in names:
        if name.endswith(_METADATA):
            yield from _group(os.path.join(folder, name, "entry_points.txt"))


def _group(file: str) -> Iterator[tuple[str, str, str]]:
    try:
        with open(file, encoding="utf-8") as stream:
            text = stream.read(_LARGEST)
    except (OSError, UnicodeDecodeError):
        return
    section = ""
    for line in text.splitlines():
        heading = _SECTION.fullmatch(line)
        if heading:
            section = heading[1].strip()
        elif section == GROUP:
            entry = _ENTRY.fullmatch(line)
            if entry:
                yield entry[1], entry[2], entry[3]


def package_of(file: str) -> str:
    """Return the package of a file by its folders that have an ``__init__.py``; mostly empty."""
    names: list[str] = []
    folder = os.path.dirname(os.path.abspath(file))
    while os.path.isfile(os.path.join(folder, "__init__.py")):
        folder, name = os.path.split(folder)
        names.append(name)
    return ".".join(reversed(names))


def file_of(module: str) -> str:
    """Return the file of a module, empty if there is none.

    Packages that it is in are looked into, not imported.
    """
    first, *rest = module.split(".")
    spec = _found(first, None)
    for part in rest:
        if spec is None or spec.submodule_search_locations is None:
            return ""
        spec = _found(part, list(spec.submodule_search_locations))
    return spec.origin or "" if spec is not None and spec.has_location else ""


def _found(name: str, places: list[str] | None) -> ModuleSpec | None:
    """Ask those that find modules: also what an editable installation has put among them."""
    if places is not None:
        return PathFinder.find_spec(name, places)
    for finder in sys.meta_path:
        spec = finder.find_spec(name, None)
        if spec is not None:
            return spec
    return None
