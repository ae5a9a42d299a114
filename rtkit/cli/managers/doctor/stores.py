"""Checks the stores of managers for their next start: set aside ones, and waiting ones."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

from rtkit.cli.managers.doctor.diagnosis import NOTE, OK, WARNING, Diagnosis
from rtkit.link import places

_SUFFIX = ".desired"
_ASIDE = re.compile(r"(.+)\.desired\.(damaged|unrestored)-\d+")


def stores() -> Iterator[Diagnosis]:
    """Look at the stores of all managers of this user."""
    folder = places.state_dir()
    try:
        entries = sorted(os.listdir(folder))
    except OSError:
        return
    found = [*_aside(folder, entries), *_waiting(entries)]
    yield from found or [Diagnosis("stores", OK, "no manager has lost what it kept")]


def _aside(folder: str, entries: list[str]) -> Iterator[Diagnosis]:
    for entry in entries:
        match = _ASIDE.fullmatch(entry)
        if match is None:
            continue
        path = os.path.join(folder, entry)
        name, what = match.groups()
        text = f"a {what} state store of manager {name!r} was put aside: {path}"
        cure = f"look whether all is there (rtls), then rm {places.quoted(path)}*"
        yield Diagnosis("stores", WARNING if what == "damaged" else NOTE, text, cure, path)


def _waiting(entries: list[str]) -> Iterator[Diagnosis]:
    for entry in entries:
        name = entry.removesuffix(_SUFFIX)
        if name == entry or places.owner(name) is not None:
            continue
        quoted = places.quoted(name)
        text = f"manager {name!r} does not run, and has kept what it held"
        cure = f"rtmgr start {quoted} brings it back, rtmgr stop {quoted} forgets it"
        yield Diagnosis("stores", NOTE, text, cure, name)
