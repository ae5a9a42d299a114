"""Tells what the packages of this host are to a system, and notes which systems need which.

The note, of systems that plans installed a package for, lies in the folder of the package, and goes
with it. What users installed has none.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Collection, Iterable, Iterator

from rtkit.errors import Unreachable
from rtkit.packages.installed import SYSTEMS, installed
from rtkit.packages.offering import offerings
from rtkit.packages.records import Installed, Question, Survey
from rtkit.packages.usage import users


def survey(asked: Question, timeout_s: float) -> Survey:
    """Look at the packages of this host."""
    known = installed()
    found = offerings(asked.types) if known else {}
    needed = {each[0].package.text for each in found.values()}
    if asked.notes:
        _note_needed(asked.system, needed)
    unknown: list[str] = []
    gone = {
        each.text: os.path.realpath(each.path)
        for each in known
        if each.text not in needed
        and _systems(each) == {asked.system}
        and {*asked.managers}.issuperset(_users(each, timeout_s, unknown))
    }
    offers = {id: tuple(each) for id, each in found.items()}
    return Survey(tuple(each.text for each in known), offers, gone, "; ".join(unknown))


def _users(package: Installed, timeout_s: float, unknown: list[str]) -> Iterator[str]:
    try:
        yield from users(package, timeout_s)
    except Unreachable as error:
        unknown.append(str(error))
        yield ""  # perhaps one that does not answer


def _systems(package: Installed) -> set[str]:
    """Return the ids of the systems that a package was installed for; none if a user did it."""
    try:
        with open(os.path.join(package.path, SYSTEMS), encoding="utf-8") as file:
            return {str(each) for each in json.load(file)}
    except (OSError, ValueError, TypeError):
        return set()


def _note(folder: str, ids: Iterable[str]) -> None:
    """Write for which systems the package in a folder is there, replaced as a whole."""
    with tempfile.NamedTemporaryFile("w", dir=folder, delete=False, encoding="utf-8") as draft:
        json.dump(sorted(ids), draft)
    os.replace(draft.name, os.path.join(folder, SYSTEMS))


def _note_needed(system: str, needed: Collection[str]) -> None:
    """Note that a system needs packages too that were installed for others."""
    for each in installed() if needed else ():
        known = _systems(each)
        if each.text in needed and known and system not in known:
            _note(each.path, {*known, system})
