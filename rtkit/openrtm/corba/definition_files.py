"""Reads the IDL files of a folder together, once for all processes.

The parser of IDL takes longer to set up than a component to start, so what was read is kept in
``__pycache__`` of the folder, under the content of all files that it depends on.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from rtkit.builder.standard_types import KNOWN
from rtkit.errors import InvalidDocument
from rtkit.idl.model import Declaration, Definitions, Opaque, Path
from rtkit.settings.kept_files import keep, kept
from rtkit.version import __version__

Read = Callable[[str], bytes]
_INCLUDED = re.compile(rb"^[ \t]*#[ \t]*include[ \t]*[<\"]([^>\"]+)", re.MULTILINE)
_KEPT_IN = "definitions.rtkit.pickle"


class ReadDefinitions(NamedTuple):
    """Declarations of all files of a folder.

    Attributes:
        failures: Why files could not be read.
    """

    definitions: Definitions
    failures: tuple[str, ...]


def read_all(folder: str, files: Sequence[str], read: Read) -> ReadDefinitions:
    """Return all that files declare, IDL or what omniidl made of it; it is kept in the folder."""
    if not files:
        return ReadDefinitions(Definitions({}), ())
    reader = _Reader(files, read)
    path = os.path.join(folder, "__pycache__", _KEPT_IN)
    head = reader.key()
    import pickle  # only for components with definitions

    body = kept(path, head)
    if body is not None:
        try:
            found: ReadDefinitions = pickle.loads(body)
            return found
        except (pickle.UnpicklingError, AttributeError, ImportError, EOFError, TypeError):
            pass  # it was cut short, and is read anew
    found = reader.all()
    keep(path, head, pickle.dumps(found))
    return found


class _Reader:
    def __init__(self, files: Sequence[str], read: Read) -> None:
        self._files = files
        self._read = read

    def key(self) -> bytes:
        """Return what changes with any file that counts, of equal length each time."""
        digest = hashlib.sha256(__version__.encode())
        for file in self._closure():
            digest.update(b"\0" + os.fsencode(file) + b"\0" + self._read(file))
        return digest.digest()

    def _closure(self) -> Iterator[str]:
        """Yield all files, with those that they include."""
        seen: set[str] = set()
        left = list(self._files)
        while left:
            file = left.pop(0)
            if file not in seen:
                seen.add(file)
                yield file
                names = _INCLUDED.findall(self._read(file))
                found = (self._place(os.fsdecode(each), file) for each in names)
                left += [each for each in found if each is not None]

    def all(self) -> ReadDefinitions:
        """Read all files."""
        merged: dict[Path, Declaration] = {}
        failures: list[str] = []
        for file in self._files:
            try:
                read = self._declared_in(file)
            except (InvalidDocument, SyntaxError) as error:
                failures.append(str(error))
                continue
            for path, declared in read.by_path.items():
                if path not in merged or isinstance(merged[path], Opaque):
                    merged[path] = declared
        return ReadDefinitions(Definitions(merged), tuple(failures))

    def _declared_in(self, file: str) -> Definitions:
        text = self._read(file).decode("utf-8", "replace")
        if file.endswith(".py"):
            from rtkit.openrtm.corba.stubs import read_stub

            return read_stub(text, file)
        from rtkit.idl.read import read_idl

        return read_idl(text, file, self._included, KNOWN)

    def _included(self, name: str, including: str) -> tuple[str, str] | None:
        place = self._place(name, including)
        return (place, self._read(place).decode("utf-8", "replace")) if place else None

    def _place(self, name: str, including: str) -> str | None:
        """Return where an included file is: beside the one that includes it, or known by name."""
        base = os.path.basename(name)
        own = os.path.normpath(os.path.join(os.path.dirname(including), name))
        places = [own, *(each for each in self._files if os.path.basename(each) == base)]
        return next(filter(os.path.isfile, places), None)
