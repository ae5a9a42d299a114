"""Copies of files before they are replaced: NAME.bak, NAME.bak2 …, the oldest first."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from typing import NamedTuple

from rtkit.errors import NotFound
from rtkit.link.atomic import write_output

MOST = 10
"""So many copies of a file are kept, unless another number is asked for."""
_NAME = re.compile(r"(?P<file>.+)\.bak(?P<number>\d*)")


class BackupCopy(NamedTuple):
    """A copy of a file.

    Attributes:
        path: Where it is.
        file: The file that it is a copy of.
        number: Grows from copy to copy of one file.
    """

    path: str
    file: str
    number: int


def keep(path: str, most: int = MOST) -> None:
    """Keep a copy of a file that is to be replaced; of more than `most` the oldest ones go."""
    if most < 1:
        return
    known = sorted(copies_of(path), key=lambda each: each.number)
    for each in known[: max(0, len(known) - most + 1)]:
        os.remove(each.path)
    number = 1
    for each in known[max(0, len(known) - most + 1) :]:  # no gap stays: the next one is the latest
        if each.number != number:
            os.replace(each.path, _name(path, number))
        number += 1
    os.link(path, _name(path, number))


def copies_of(path: str) -> Iterator[BackupCopy]:
    """Yield the copies of a file."""
    folder = os.path.dirname(path) or "."
    for each in copies_in(folder, is_deep=False):
        if os.path.basename(each.file) == os.path.basename(path):
            yield BackupCopy(os.path.join(os.path.dirname(path), os.path.basename(each.path)),
                             path, each.number)  # fmt: skip


def copies_in(folder: str, *, is_deep: bool = True) -> Iterator[BackupCopy]:
    """Yield the copies in a folder, and in those below it; links are no copies."""
    for at, below, names in os.walk(folder):
        below[:] = sorted(each for each in below if not each.startswith(".")) if is_deep else []
        for name in sorted(names):
            found = _NAME.fullmatch(name)
            path = os.path.join(at, name)
            if found is not None and not os.path.islink(path):
                number = int(found["number"] or 1)
                yield BackupCopy(path, os.path.join(at, found["file"]), number)


def put_back(copy: BackupCopy, most: int = MOST) -> None:
    """Have a copy be the file again; what is there is kept as the latest copy.

    Raises:
        NotFound: The copy is gone.
    """
    try:
        with open(copy.path, "rb") as stream:
            data = stream.read()
    except FileNotFoundError:
        raise NotFound(f"No such backup: {copy.path}") from None
    os.remove(copy.path)
    if os.path.lexists(copy.file):
        keep(copy.file, most)
    write_output(data, copy.file)


def _name(path: str, number: int) -> str:
    return f"{path}.bak{number if number > 1 else ''}"
