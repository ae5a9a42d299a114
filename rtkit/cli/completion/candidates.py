"""Candidates for the word at the cursor; file names where a shell cannot list them itself."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import NamedTuple

_GOES_ON = ("/", ":", "=", ".")


class Candidate(NamedTuple):
    """One way to go on.

    Attributes:
        text: The whole word as it would be, without quotes.
        about: Its description in a few words, for shells that show one.
    """

    text: str
    about: str = ""

    @property
    def is_open(self) -> bool:
        """Return whether the word goes on behind it: no blank is to follow."""
        return self.text.endswith(_GOES_ON)


class Files(NamedTuple):
    """Request for a file name, which the shell itself completes.

    Attributes:
        endings: Those of files that fit, ``.xml``; none when any does.
        is_folder: Only folders are meant.
    """

    endings: tuple[str, ...] = ()
    is_folder: bool = False


def those(words: Iterable[str], typed: str, about: str = "") -> list[Candidate]:
    """Return the words that begin as typed, each once."""
    return [Candidate(word, about) for word in dict.fromkeys(words) if word.startswith(typed)]


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
