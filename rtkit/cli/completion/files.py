"""Lists file names for a shell that cannot restrict them to the endings wanted."""

from __future__ import annotations

import os

from rtkit.cli.completion.candidates import Candidate, Files


def named(meant: Files, typed: str) -> list[Candidate]:
    """Return the files and folders that begin as typed; ``~`` stands for the home."""
    head, slash, start = typed.rpartition("/")
    above = head + slash
    try:
        entries = sorted(os.scandir(os.path.expanduser(above) or "."), key=lambda each: each.name)
    except OSError:
        return []  # no such folder, or none that may be read: nothing to be named
    found = []
    for entry in entries:
        if not entry.name.startswith(start) or (entry.name.startswith(".") and not start):
            continue
        if entry.is_dir():
            found.append(Candidate(f"{above}{entry.name}/"))
        elif not meant.is_folder and (not meant.endings or entry.name.endswith(meant.endings)):
            found.append(Candidate(f"{above}{entry.name}"))
    return [each for each in found if each.text.isprintable()]
