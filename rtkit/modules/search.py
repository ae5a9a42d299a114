"""Finds modules: by name inside the load paths, by absolute path where that is allowed.

A name leads to no other place: neither by ``..`` nor by a link. The checked file is read.
One that no load path has may be that of a module of an installed package: as that package names
it for components or, where absolute paths are allowed, as Python does (``robot.arm``). Packages
declare entry points of the group ``rtkit.components``, ``NAME = MODULE:INIT``: the module is
requested by NAME, usually the name of its component type, or by MODULE. None of them is run to be
found. Of packages that ``rtpkg`` installed there may be several versions: ``NAME==VERSION`` is one
of them, NAME the newest, and a type with a version the one that has it.
"""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from typing import NamedTuple

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.modules.describing import describe
from rtkit.modules.package_folders import folders
from rtkit.rtc.create import CreateString
from rtkit.rtc.nearest import did_you_mean
from rtkit.rtc.profiles import TypeProfile
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
    """Location of a module: file, load path that it has to be in, if any, init and package.

    Attributes:
        pinned: ``NAME==VERSION``, where several versions may be installed; else empty.
    """

    file: str = ""
    folder: str = ""
    init: str = ""
    package: str = ""
    pinned: str = ""

    @property
    def name(self) -> str:
        """The name by which it is found again: that by which Python knows it, or the pinned one."""
        if self.pinned:
            return self.pinned
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
        file, folder, init, package, _ = place
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

    def path_of(self, create: CreateString) -> str:
        """Return by which path the module of a type is found: by its name, or a version of that."""
        name = create.implementation_id
        usual = f"{name}{SUFFIX}"
        if not (create.vendor or create.category or create.version):
            return usual
        pinned = [key for key in versions() if key.partition("==")[0] == name]
        paths = [usual, *pinned] if pinned else []
        return next((path for path in paths if self._offers(path, create)), usual)

    def _offers(self, path: str, create: CreateString) -> bool:
        try:
            source = self.read(path)
            found = describe(source.text, source.file, source.init, source.package)
        except (NotFound, Refused, Malformed):
            return False
        return is_among(create, [each.type for each in found or ()])

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
        known = there.get(path.removesuffix(SUFFIX)) or versions().get(path)
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
    for pinned, place in versions().items():
        found.setdefault(pinned.partition("==")[0], place)
    return found


def versions() -> dict[str, ModulePlace]:
    """Return the modules of each version of the user's packages, the newest first, by pinned name.

    One that is only there for a package that needs it comes behind those that are packages of
    their own.
    """
    found: dict[str, ModulePlace] = {}
    needed: dict[str, ModulePlace] = {}
    for each in folders():
        for owner, version, entries in _distributions(each.path):
            for name, module, init in entries:
                file = file_of(module, [each.path])
                if file:
                    pinned = f"{name}=={version}"
                    package = module.rpartition(".")[0]
                    among = found if owner == each.name else needed
                    place = ModulePlace(file, init=init, package=package, pinned=pinned)
                    among.setdefault(pinned, place)
    return found | {key: place for key, place in needed.items() if key not in found}


def _distributions(folder: str) -> Iterator[tuple[str, str, Iterator[tuple[str, str, str]]]]:
    """Yield name, version and entry points of each package that a folder has."""
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return
    for name in names:
        stem = name.removesuffix(".dist-info")
        if stem != name:
            owner, _, version = stem.partition("-")
            file = os.path.join(folder, name, "entry_points.txt")
            yield owner.replace("_", "-").lower(), version, _group(file)


def is_among(create: CreateString, types: Sequence[TypeProfile]) -> bool:
    """Return whether one of the types is what a create string means."""
    fields = ("vendor", "category", "language", "version")
    return any(
        each.type_name == create.implementation_id
        and all(getattr(create, key) in ("", getattr(each, key)) for key in fields)
        for each in types
    )


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
    yield from entry_points(text)


def entry_points(text: str) -> Iterator[tuple[str, str, str]]:
    """Yield name, module and init function of each entry point of components in such a file."""
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


def file_of(module: str, places: list[str] | None = None) -> str:
    """Return the file of a module, empty if there is none; looked for in those folders, if given.

    Packages that it is in are looked into, not imported.
    """
    first, *rest = module.split(".")
    spec = _found(first, places)
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
