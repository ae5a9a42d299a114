"""Reads and writes the files of a component on disk: sources of a build and its results."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.builder.component_files import PROFILE, File, build, build_types
from rtkit.builder.merge import Merged, MergeOutcome, merge
from rtkit.builder.prepare import Sources, idl_files, is_declared, undefined
from rtkit.builder.standard_types import IMAGES, KNOWN, expression
from rtkit.cli.shared.profile_files import STDIN, read_input
from rtkit.errors import InvalidDocument, NotFound, Refused
from rtkit.fast_dataclass import dataclass, field
from rtkit.idl.read import read_idl
from rtkit.profile.read import read_bytes, read_rtc

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rtkit.idl.model import Definitions, Path
    from rtkit.profile.rtc_model import RtcProfile

_ROOT = "RTM_ROOT"


@dataclass(slots=True)
class Project:
    """The desired files of a component on disk.

    Attributes:
        files: By path.
        notes: Notes that the user should read.
        remarks: Notes that are shown on request.
        other: Type of the component to which the folder belongs, if that is another one.
    """

    folder: str
    files: dict[str, File]
    notes: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    other: str = ""


class FileChange(NamedTuple):
    """The change of one file."""

    path: str
    merged: Merged

    @property
    def is_conflict(self) -> bool:
        """Return whether it cannot be written without losing something."""
        return self.merged.assignment is MergeOutcome.CONFLICT

    def assignment_when(self, *, is_forced: bool) -> str:
        """Return the assignment of the file in a word."""
        is_written = is_forced and self.merged.assignment in (
            MergeOutcome.CONFLICT,
            MergeOutcome.KEEP,
        )
        return (MergeOutcome.WRITE if is_written else self.merged.assignment).value


class _Idl:
    """Finds IDL files and remembers which were read."""

    def __init__(self, folders: Iterable[str]) -> None:
        self.folders = [folder for folder in folders if folder]
        self.read: dict[str, str] = {}

    def find(self, name: str, including: str = "") -> tuple[str, str] | None:
        """Return path and text of a file, wherever it is; None when it is nowhere."""
        plain = name.replace("\\", "/").replace(f"<{_ROOT}>", os.environ.get(_ROOT, ""))
        folders = [os.path.dirname(including)] if including else []
        for folder in [*folders, *self.folders]:
            for tail in dict.fromkeys([plain, os.path.basename(plain)]):
                path = os.path.join(folder, tail)
                if tail and os.path.isfile(path):
                    path = os.path.normpath(path)
                    return path, self.text(path)
        return None

    def others(self) -> Iterator[str]:
        """Yield the paths of the files that lie where is looked and were not read yet."""
        for folder in self.folders:
            try:
                names = sorted(os.listdir(folder))
            except OSError:
                continue
            paths = (os.path.normpath(os.path.join(folder, name)) for name in names)
            yield from (p for p in paths if p.lower().endswith(".idl") and p not in self.read)

    def text(self, path: str) -> str:
        """Return the text of a file; comments may be of any encoding."""
        self.read[path] = read_bytes(path).decode("utf-8", "replace")
        return self.read[path]


def read(
    typed: str, output: str | None, folders: Sequence[str], *, has_mirror: bool = False
) -> Project:
    """Read a profile or an IDL file and generate its files.

    Raises:
        NotFound: A file cannot be read.
        InvalidDocument: It is neither, or something is wrong with it.
    """
    beside = os.path.dirname(typed) if typed != STDIN else ""
    folder = output if output is not None else beside
    root = os.environ.get(_ROOT, "")
    places = [beside or ".", os.path.join(beside, "idl"), *folders]
    idl = _Idl([*places, root and os.path.join(root, "rtm", "idl")])
    if typed.lower().endswith(".idl"):
        return _types_alone(typed, folder, idl)
    name, data = read_input(typed)
    reading = read_rtc(data, name)
    named = [path for name in idl_files(reading.profile) if (path := _path(idl, name))]
    definitions = _definitions(named, idl)
    more = _defining(undefined(reading.profile, definitions), idl)
    if more:
        definitions = _definitions([*named, *more], idl)
    sources = {os.path.basename(path): text for path, text in idl.read.items()}
    stem = os.path.basename(typed).partition(".")[0] if typed != STDIN else "Component"
    drawn = _drawn(reading.profile, beside)
    found = Sources(stem, definitions, drawn)
    built = build(reading.profile, found, tuple(sources), has_mirror=has_mirror)
    project = Project(folder, dict(built.files), list(built.notes))
    project.notes += [f"{path}: not named by the profile; types are taken from it" for path in more]
    project.remarks = [f"{typed}:{note.line}: {note.text}" for note in reading.notes]
    project.files |= {f"idl/{name}": File(text) for name, text in sources.items()}
    present = os.path.join(folder, PROFILE)
    if _is_same(typed, present):
        project.files.pop(PROFILE)
    elif os.path.isfile(present):
        project.other = _other_type(present, built.subject.info.name)
    return project


def _other_type(file: str, own: str) -> str:
    """Return the type that a profile describes if it is another one than `own`."""
    try:
        info = read_rtc(read_bytes(file), file).profile.basic_info
    except (InvalidDocument, NotFound):
        return ""
    return info.name if info is not None and info.name != own else ""


def _types_alone(typed: str, folder: str, idl: _Idl) -> Project:
    text = idl.text(typed)
    name = os.path.basename(typed)
    definitions = read_idl(text, typed, idl.find, KNOWN)
    built, notes = build_types(definitions, name)
    stock = [path for path in definitions.by_path if path in KNOWN]
    if stock and not built:
        notes.append(f"{typed}: {_built_in(stock)}; there is nothing to generate")
    elif not built:
        raise Refused(f"{typed}: nothing in it can be carried{_listed(notes)}")
    return Project(folder, built, notes)


def _built_in(paths: Sequence[Path]) -> str:
    """Return where code finds types that rtkit has."""
    first = expression(paths[0])
    where = IMAGES if first.startswith("images.") else "from rtkit import component as rt"
    return f"its {len(paths)} types are built in ({where}; {first} …)"


def _listed(notes: Sequence[str]) -> str:
    return f": {'; '.join(notes)}" if notes else ""


def _definitions(paths: Iterable[str], idl: _Idl) -> Definitions:
    """Return the declarations of all IDL files together."""
    text = "".join(f'#include "{path}"\n' for path in dict.fromkeys(paths))
    return read_idl(text, "", lambda name, file: _included(idl, name, file), KNOWN)


def _defining(types: Sequence[str], idl: _Idl) -> list[str]:
    """Return the files, of those that no profile names, that declare these types.

    Real profiles often leave open where the types of their data ports are. A file that cannot be
    read is passed over: nobody asked for it.
    """
    found = []
    wanted = set(types)
    for path in idl.others() if types else ():
        tried = _Idl(idl.folders)
        try:
            declared = _definitions([path], tried)
        except (InvalidDocument, NotFound):
            continue
        here = {text for text in wanted if is_declared(text, declared)}
        if here:
            found.append(path)
            wanted -= here
    return found


def _path(idl: _Idl, name: str) -> str:
    found = idl.find(name)
    return found[0] if found else ""


def _included(idl: _Idl, name: str, file: str) -> tuple[str, str] | None:
    return (name, idl.text(name)) if not file else idl.find(name, file)


def _drawn(profile: RtcProfile, beside: str) -> Mapping[str, Mapping[str, str]] | None:
    """Return the states of a machine that is drawn beside the profile."""
    info = profile.basic_info
    for name in (f"{info.name}FSM.scxml", f"{info.name}.scxml") if info else ():
        path = os.path.join(beside, os.path.basename(name))
        if os.path.isfile(path):
            from rtkit.profile.scxml import read_scxml

            return read_scxml(read_bytes(path), path).states
    return None


def _is_same(one: str, other: str) -> bool:
    return one != STDIN and os.path.exists(other) and os.path.samefile(one, other)


def compare(project: Project) -> list[FileChange]:
    """Return the change of each file.

    Raises:
        NotFound: A file that is there cannot be read.
    """
    return [
        FileChange(path, _merged(path, file))
        for name, file in project.files.items()
        for path in [os.path.join(project.folder, *name.split("/"))]
    ]


def _merged(path: str, file: File) -> Merged:
    if not os.path.lexists(path):
        return merge(None, file.text, has_regions=file.has_regions)
    try:
        old = read_bytes(path).decode("utf-8").replace("\r\n", "\n")
    except UnicodeDecodeError:
        why = "it is not of UTF-8"
        return Merged(
            MergeOutcome.CONFLICT if file.has_regions else MergeOutcome.KEEP, file.text, why, 1
        )
    return merge(old, file.text, has_regions=file.has_regions)


def write(changes: Sequence[FileChange], *, is_forced: bool) -> None:
    """Write all changed files, or none where one cannot be written."""
    wanted = [
        each
        for each in changes
        if each.assignment_when(is_forced=is_forced) == MergeOutcome.WRITE.value
    ]
    staged: list[tuple[str, str]] = []
    try:
        for each in wanted:
            os.makedirs(os.path.dirname(each.path) or ".", exist_ok=True)
            staged.append((_stage(each.path, each.merged.text), each.path))
        for each in wanted:
            if each.merged.assignment is not MergeOutcome.WRITE:
                _keep(each.path)
        while staged:
            os.replace(*staged[0])
            staged.pop(0)
    finally:
        for temporary, _ in staged:
            os.unlink(temporary)


def _stage(path: str, text: str) -> str:
    """Write the text beside its place, with the mode that the file is to have."""
    temporary = f"{path}.{os.getpid()}.new"
    if os.path.isdir(path):
        raise NotFound(f"{path} is a folder")
    descriptor = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    with open(descriptor, "w", encoding="utf-8", newline="\n") as stream:
        stream.write(text)
    if os.path.exists(path):
        os.chmod(temporary, os.stat(path).st_mode & 0o777)
    return temporary


def _keep(path: str) -> None:
    for name in _backups(path):
        try:
            os.link(path, name)
        except FileExistsError:
            continue
        return


def _backups(path: str) -> Iterator[str]:
    yield f"{path}.bak"
    number = 1
    while True:
        number += 1
        yield f"{path}.bak{number}"
