"""Migrates files from older versions of Python, with the files beside them that they import.

All are converted before any is written; where one cannot be written, the others are put back.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from typing import NamedTuple

from rtkit.errors import NotFound, RtkitError
from rtkit.link.atomic import write_output
from rtkit.openrtm.migrate.python2 import TOKEN
from rtkit.openrtm.migrate.source import read_source
from rtkit.openrtm.migrate.to_python3 import ConvertedSource, converted

_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+(?P<within>\.*[\w.]*)[ \t]+import[ \t]+\(?(?P<names>[\w \t,.*]+)"
    r"|import[ \t]+(?P<modules>[\w \t,.]+))",
    re.MULTILINE,
)
_KEPT = ".orig"


class MigratedFile(NamedTuple):
    """A file that is of an older Python.

    Attributes:
        path: Where it is.
        source: The file as the Python of today has it.
        beside: It was not named, but is imported by a file that was.
    """

    path: str
    source: ConvertedSource
    beside: bool


class Migration(NamedTuple):
    """Files that were looked at, and those of them that are to be migrated.

    Attributes:
        looked_at: Paths of all.
        files: Those that are to be written.
        others: Those in which nothing can be mended for certain, but a person should look.
    """

    looked_at: tuple[str, ...]
    files: tuple[MigratedFile, ...]
    others: tuple[MigratedFile, ...] = ()


def plan_migration(paths: Iterable[str]) -> Migration:
    """Convert files and those beside them that they import; nothing is written.

    Raises:
        NotFound: One cannot be read.
        Malformed: One cannot be converted.
        Refused: What converts them is not installed.
    """
    named = [os.path.normpath(path) for path in paths]
    looked_at: dict[str, bytes] = {}
    packages: set[str] = set()
    waiting = list(dict.fromkeys(named))
    while waiting:
        path = waiting.pop(0)
        if path not in looked_at:
            looked_at[path] = content_of(path)
            imported = list(imported_files(looked_at[path], path))
            packages |= {*map(os.path.dirname, imported)} - {os.path.dirname(path)}
            waiting += imported
    found = []
    for path, content in looked_at.items():
        is_in_package = os.path.dirname(path) in packages and _is_package(os.path.dirname(path))
        source = converted(content, path, is_in_package=is_in_package)
        if source is not None:
            found.append(MigratedFile(path, source, path not in named))
    files = tuple(each for each in found if each.source.is_changed)
    others = tuple(each for each in found if not each.source.is_changed)
    return Migration(tuple(looked_at), files, others)


def _is_package(folder: str) -> bool:
    return os.path.isfile(os.path.join(folder, "__init__.py"))


def imported_files(content: bytes, path: str) -> Iterator[str]:
    """Yield the files beside a source, and in packages there, that it imports."""
    bare = TOKEN.sub(lambda match: "''" if match[0][0] != "#" else "", read_source(content).text)
    folder = os.path.dirname(path)
    for match in _IMPORT.finditer(bare.replace("\\\n", " ")):
        if match["modules"] is not None:
            names = [each.split()[0] for each in match["modules"].split(",") if each.split()]
            for name in names:
                yield from _files_of(folder, name)
        else:
            within = match["within"]
            up = len(within) - len(within.lstrip("."))
            place = os.path.normpath(os.path.join(folder, *[".."] * max(0, up - 1)))
            within = within.lstrip(".")
            yield from _files_of(place, within) if within else ()
            inner = os.path.join(place, *within.split(".")) if within else place
            for each in match["names"].split(","):
                if each.split():
                    yield from _files_of(inner, each.split()[0])


def _files_of(folder: str, name: str) -> Iterator[str]:
    """Yield the files of a module in a folder, and those of the packages that it is in."""
    parts = name.strip(".").split(".")
    for count in range(1, len(parts) + 1):
        stem = os.path.join(folder, *parts[:count])
        for file in (f"{stem}.py", os.path.join(stem, "__init__.py")):
            if os.path.isfile(file):
                yield os.path.normpath(file)


def migrate(migration: Migration) -> dict[str, str]:
    """Write all files, or none; return where the original of each is kept, by path.

    Raises:
        NotFound: One cannot be written.
    """
    kept: dict[str, str] = {}
    try:
        for each in migration.files:
            place = os.path.realpath(each.path)
            kept[each.path] = _keep(place)
            write_output(each.source.data, place)
    except (OSError, RtkitError) as error:
        for path, original in kept.items():
            with suppress(FileNotFoundError):
                os.replace(original, os.path.realpath(path))
                os.unlink(original)  # where it had not been replaced yet, both are one file
        why = error.strerror if isinstance(error, OSError) else str(error)
        raise NotFound(f"nothing was migrated: {each.path}: {why}") from error
    return kept


def _keep(place: str) -> str:
    """Keep a copy of a file that is to be replaced; return where."""
    number = 1
    while os.path.lexists(original := f"{place}{_KEPT}{number if number > 1 else ''}"):
        number += 1
    try:
        os.link(place, original)
    except OSError:  # not every file system has links
        write_output(content_of(place), original, is_new=True)
    return original


def content_of(path: str) -> bytes:
    """Return what is in a file.

    Raises:
        NotFound: It cannot be read.
    """
    try:
        with open(path, "rb") as stream:
            return stream.read()
    except OSError as error:
        raise NotFound(f"cannot read {path}: {error.strerror}") from error
