"""Notes which systems packages were installed for, by plans; what users installed has no note.

The note lies in the folder of the package, and goes with it.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Collection, Iterable

from rtkit.packages.installed import Installed, installed

_FILE = ".rtkit-systems.json"


def systems(package: Installed) -> set[str]:
    """Return the ids of the systems that a package was installed for; none if a user did it."""
    try:
        with open(os.path.join(package.path, _FILE), encoding="utf-8") as file:
            return {str(each) for each in json.load(file)}
    except (OSError, ValueError, TypeError):
        return set()


def note(folder: str, ids: Iterable[str]) -> None:
    """Write for which systems the package in a folder is there, replaced as a whole."""
    with tempfile.NamedTemporaryFile("w", dir=folder, delete=False, encoding="utf-8") as draft:
        json.dump(sorted(ids), draft)
    os.replace(draft.name, os.path.join(folder, _FILE))


def surplus(system: str, needed: Collection[str]) -> list[Installed]:
    """Return the packages that were installed for a system alone, and that it needs no longer."""
    return [each for each in installed() if each.text not in needed and systems(each) == {system}]


def note_needed(system: str, needed: Collection[str]) -> None:
    """Note that a system needs packages too that were installed for others."""
    for each in installed() if needed else ():
        known = systems(each)
        if each.text in needed and known and system not in known:
            note(each.path, {*known, system})
