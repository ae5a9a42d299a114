"""Expands arguments to documents: files, folders with all below them, standard input."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rtkit.cli.shared.app import WrongArguments

STDIN, STDIN_NAME = "-", "<stdin>"
_ENDINGS = (".xml", ".rtsys", ".yaml", ".yml", ".json")
_MOST = 16 * 2**20


def read_input(file: str | None) -> tuple[str, bytes]:
    """Return name and content of a file, or of stdin for ``-`` and none; of too long ones a part.

    Raises:
        NotFound: The file cannot be read.
    """
    from rtkit.profile.parse import MAX_BYTES
    from rtkit.profile.read import read_bytes

    if file is None or file == STDIN:
        return STDIN_NAME, sys.stdin.buffer.read(MAX_BYTES + 1)
    return file, read_bytes(file)


class DocumentSource(NamedTuple):
    """A document, or why it cannot be had.

    Attributes:
        name: As the user typed it, with what is below a folder.
        data: Up to a size that no profile reaches; None where it cannot be read.
        problem: Why not.
        is_named: Whether the user named it, rather than a folder in which it lies.
    """

    name: str
    data: bytes | None
    problem: str = ""
    is_named: bool = True


def sources(paths: Sequence[str]) -> Iterator[DocumentSource]:
    """Yield the documents that are meant, each when it is asked for; no path means stdin.

    Raises:
        WrongArguments: Nothing is named, and stdin is a terminal.
    """
    if not paths and (sys.stdin is None or sys.stdin.isatty()):
        raise WrongArguments("No file specified.")
    for path in paths or (STDIN,):
        if path == STDIN:
            yield DocumentSource(STDIN_NAME, sys.stdin.buffer.read(_MOST))
        elif os.path.isdir(path):
            yield from _below(path)
        else:
            yield _read(path, is_named=True)


def _below(folder: str) -> Iterator[DocumentSource]:
    problems: list[OSError] = []
    for place, folders, files in os.walk(folder, onerror=problems.append):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(files):
            path = os.path.join(place, name)
            if name.lower().endswith(_ENDINGS) and os.path.isfile(path):
                yield _read(path, is_named=False)
    for problem in problems:
        yield DocumentSource(str(problem.filename), None, str(problem.strerror))


def _read(path: str, *, is_named: bool) -> DocumentSource:
    try:
        with open(path, "rb") as stream:
            return DocumentSource(path, stream.read(_MOST), is_named=is_named)
    except OSError as error:
        return DocumentSource(path, None, error.strerror or str(error))
    except ValueError as error:
        return DocumentSource(path, None, str(error))
