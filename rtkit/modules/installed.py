"""Finds component modules that were installed as packages, without running any of them.

Packages declare entry points of the group ``rtkit.components``, ``NAME = MODULE:INIT``: the module
is requested by NAME, usually the name of its component type.
"""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections.abc import Iterator
from importlib.machinery import ModuleSpec, PathFinder
from typing import NamedTuple

GROUP = "rtkit.components"
_METADATA = (".dist-info", ".egg-info")
_SECTION = re.compile(r"\s*\[(.*)\]\s*")
_ENTRY = re.compile(r"\s*([^=#;\s][^=]*?)\s*=\s*([\w.]+)\s*:\s*(\w+)\s*(?:\[.*\])?\s*")
_LARGEST = 1 << 20


class Installed(NamedTuple):
    """A module of an installed package."""

    name: str
    file: str
    init: str


def installed() -> dict[str, Installed]:
    """Return the modules of all packages that Python finds here, by name; the first one counts."""
    importlib.invalidate_caches()
    found: dict[str, Installed] = {}
    for folder in dict.fromkeys(sys.path):
        for name, module, init in _entries(folder):
            file = "" if name in found else file_of(module)
            if file:
                found[name] = Installed(name, file, init)
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
