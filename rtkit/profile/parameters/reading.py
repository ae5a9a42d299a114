"""Reads a system profile with all that it includes, and names file and line of what is wrong."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import NamedTuple

from rtkit.errors import InvalidDocument, NotFound, Refused, UsageProblem
from rtkit.profile.common import Note
from rtkit.profile.examine import Position, Positions, at_their_lines, examine
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.forms import XML, form_of
from rtkit.profile.parameters import SystemParameters
from rtkit.profile.parameters.resolve import (
    LISTED,
    ProfileOrigin,
    ResolvedProfile,
    SourceProfile,
    Step,
    UnknownValue,
    UnresolvedPart,
    resolve,
)
from rtkit.profile.read import read_bytes, read_rts
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.write import write_rts


class SourcePosition(NamedTuple):
    """The file, line and XPath of a part of a resolved profile."""

    file: str
    line: int
    path: str


class SystemReading(NamedTuple):
    """A resolved system profile.

    Attributes:
        data: Its content, as a document without parameters in the form `form`.
        notes: Repairs and remarks of all files, each with the name of the file.
        position: Where a part stands, by the fields that lead to it and one of its own.
        files: All that was read, without links, the first one first.
    """

    profile: RtsProfile
    data: bytes
    form: str
    notes: tuple[tuple[str, Note], ...]
    position: Callable[[Sequence[Step], str], SourcePosition]
    files: tuple[str, ...] = ()


def read_system(
    data: bytes,
    source: str,
    parameters: SystemParameters | None = None,
    *,
    form: str | None = None,
    strict: bool = False,
    folders: Sequence[str] = (),
) -> SystemReading:
    """Read a system profile, and resolve it.

    Args:
        data: The document.
        source: Its file; a text from elsewhere counts as lying in the working directory.
        parameters: Values, and what stands before all names.
        form: As `rtkit.profile.read.read_rts` takes it.
        strict: Refuse what would need repair.
        folders: Folders from which may be included, beside that of `source`.

    Raises:
        InvalidDocument: It, or what it includes, is no sound system profile.
        UsageProblem: A value of the command line is for nothing.
        Malformed: Another value is.
    """
    reader = _Reader(source, strict, folders)
    first = reader.read(source, data, form)
    try:
        given, prefix = parameters or SystemParameters()
        resolved = resolve(first, given, prefix, reader.load)
    except UnresolvedPart as error:
        at = reader.position(error.origin, error.name)
        raise InvalidProfile(at.file, [Note(at.line, str(error), at.path, "parameter")]) from error
    except UnknownValue as error:
        if not error.origin:
            raise
        kind = UsageProblem if error.origin.startswith("--") else InvalidDocument
        raise kind(str(error)) from error
    return reader.reading(resolved)


class _Reader:
    """Files of one system, each read once."""

    def __init__(self, source: str, strict: bool, folders: Sequence[str]) -> None:
        self._strict = strict
        here = os.path.dirname(source) if os.path.isfile(source) else os.curdir
        self._folders = [os.path.realpath(here), *map(os.path.realpath, filter(None, folders))]
        self._known: dict[str, SourceProfile] = {}
        self._data: dict[str, tuple[bytes, str]] = {}
        self._positions: dict[str, Positions | None] = {}
        self._notes: list[tuple[str, Note]] = []

    def read(self, name: str, data: bytes, form: str | None) -> SourceProfile:
        """Read one document."""
        path = os.path.realpath(name)
        reading = read_rts(data, name, form=form, strict=self._strict)
        self._data[path] = (data, form or form_of(data, name))
        self._notes += ((name, note) for note in reading.notes)
        made = self._known[path] = SourceProfile(name, path, reading.profile)
        return made

    def load(self, file: str, by: SourceProfile) -> SourceProfile:
        """Read an included document, from beside the one that includes it or a granted folder.

        Raises:
            NotFound: There is none.
            Refused: It is outside of those folders.
        """
        beside = os.path.join(os.path.dirname(by.name), file)
        places = [beside, *(os.path.join(folder, file) for folder in self._folders)]
        name = next((each for each in places if os.path.isfile(each)), None)
        if name is None:
            raise NotFound(f"no file {file}, neither beside {by.name} nor in the profile path")
        path = os.path.realpath(name)
        if not any(os.path.commonpath([path, folder]) == folder for folder in self._folders):
            raise Refused(
                f"{file} is outside of {self._folders[0]}; RTKIT_PROFILE_PATH names other folders"
                " from which profiles may be included"
            )
        return self._known.get(path) or self.read(name, read_bytes(path), None)

    def position(self, origin: ProfileOrigin, name: str, field: str = "") -> SourcePosition:
        """Return where a part stands; `name` is one of its attributes, as in the document."""
        source = origin.source
        data, form = self._data[source.path]
        if source.path not in self._positions:
            self._positions[source.path] = examine(data, source.name, form=form).positions
        positions = self._positions[source.path]
        at = positions.position(origin.steps, field) if positions else Position(1, "")
        path = f"{at.path}/@{name}" if name else at.path
        if form == XML:
            (note,) = at_their_lines([Note(at.line, "", path)], data)
            at = Position(note.line, path)
        return SourcePosition(source.name, at.line, path)

    def reading(self, resolved: ResolvedProfile) -> SystemReading:
        """Return what was read, as one document."""
        (first, *others) = self._known.values()
        data, form = self._data[first.path]
        profile = resolved.profile
        if profile != first.profile:
            data, form = write_rts(profile), XML
            # Ports that only a connector to an included component names are listed by the reader.
            profile = read_rts(data, first.name).profile if others else profile

        def position(steps: Sequence[Step], field: str) -> SourcePosition:
            part = steps[0][0] if steps else ""
            # Of an order the targets are known, each of which may come from another file.
            is_target = len(steps) > 1 and steps[1][0] == "targets"
            (_, number), *below = steps[1:] if is_target else steps or (("", 0),)
            origins = resolved.origins.get(part, ()) if is_target or part in LISTED else ()
            origin = ProfileOrigin(first, tuple(steps))
            if number < len(origins):
                known = origins[number]
                origin = known._replace(steps=(*known.steps, *below))
            return self.position(origin, "", field)

        files = tuple(self._known)
        return SystemReading(profile, data, form, tuple(self._notes), position, files)
