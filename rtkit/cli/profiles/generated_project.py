"""Reads profiles and IDL files, and generates the files of their project."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.builder.component_files import (
    PROFILE,
    Built,
    File,
    build,
    build_types,
    project_files,
)
from rtkit.builder.identifiers import module_name, type_name
from rtkit.builder.packaging import entries
from rtkit.builder.prepare import Sources, idl_files, is_declared, undefined
from rtkit.builder.regions import stamp_of
from rtkit.builder.standard_types import IMAGES, KNOWN, expression
from rtkit.cli.shared.profile_files import STDIN, read_input
from rtkit.errors import InvalidDocument, NotFound, Refused
from rtkit.fast_dataclass import dataclass, field
from rtkit.idl.read import read_idl
from rtkit.modules.search import installed
from rtkit.profile.forms import may_be_component
from rtkit.profile.read import read_bytes, read_rtc

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rtkit.idl.model import Definitions, Path
    from rtkit.profile.rtc_model import RtcProfile

_ROOT, _IDL = "RTM_ROOT", "idl"
_HEAD = 2048


@dataclass(slots=True)
class Project:
    """The desired files of a component on disk.

    Attributes:
        files: By path.
        idl_folders: Where else IDL files were looked for.
        notes: Notes that the user should read.
        remarks: Notes that are shown on request.
        other: Type of the component to which the folder belongs, if that is another one.
        entries: Lines of ``pyproject.toml`` by which the components are found.
    """

    folder: str
    files: dict[str, File]
    idl_folders: Sequence[str] = ()
    notes: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    other: str = ""
    entries: Mapping[str, str] = field(default_factory=dict)


class IdlFiles:
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


class _Member(NamedTuple):
    """A component of the project, as it would be generated.

    Attributes:
        typed: The file of its profile.
        idl: IDL files that were read, by path.
        unnamed: Those of them that the profile does not name.
    """

    typed: str
    built: Built
    idl: Mapping[str, str]
    unnamed: Sequence[str]
    remarks: Sequence[str]

    @property
    def type_name(self) -> str:
        """Name of its type as the profile has it."""
        return self.built.subject.info.name


def read(
    typed: Sequence[str],
    output: str | None,
    folders: Sequence[str],
    *,
    has_mirror: bool = False,
    adds: bool = False,
    is_forced: bool = False,
) -> Project:
    """Read profiles, or one IDL file, and generate the files of their project.

    Args:
        typed: The files.
        output: Where to write; None for the folder of the first file.
        folders: Where else IDL files are looked for.
        has_mirror: Also generate the mirror of the component.
        adds: Components that the project has stay in it.
        is_forced: They do not.

    Raises:
        NotFound: A file cannot be read.
        InvalidDocument: It is neither, or something is wrong with it.
        Refused: The files are not of one project, or it has none of what is asked for.
    """
    folder = _beside(typed[0]) if output is None else output
    folders = tuple(folders)
    are_idl = [each for each in typed if each.lower().endswith(".idl")]
    if are_idl:
        if len(typed) > 1:
            raise Refused(f"{are_idl[0]}: an IDL file is generated alone")
        return _types_alone(typed[0], folder, IdlFiles(_places(_beside(typed[0]), folders)))
    if has_mirror and len(typed) > 1:
        raise Refused("--mirror is for one component")
    own = (_member(t, folders, has_mirror, folder) for t in typed)
    given = {each.type_name: each for each in own}
    if len(given) < len(typed):
        raise Refused(f"{typed[-1]}: another file given describes the same component type")
    profiles = {} if is_forced and not adds else present_profiles(folder)
    project = Project(folder, {}, folders)
    present = os.path.join(folder, PROFILE)
    strange = [name for name in profiles if name not in given]
    if os.path.isfile(present) and not is_forced and not any(map(profiles.get, given)):
        project.other = next(iter(strange), "") or _other_type(present, next(iter(given)))
        if adds and project.other and project.other not in profiles:
            raise Refused(
                f"{present}: {project.other} is not generated there yet: rtbuild it first"
            )
    members = [given.get(name) or _member(path, folders) for name, path in profiles.items()]
    members += [each for name, each in given.items() if name not in profiles]
    _refuse_equal_files(members)
    for member in given.values():
        _take(project, member, PROFILE if member is members[0] else "")
    if len(members) > 1:
        project.files |= project_files([each.built for each in members])
    project.entries = entries([each.built.subject for each in members])
    return project


def _refuse_equal_files(members: Sequence[_Member]) -> None:
    known: dict[str, str] = {}
    for member in members:
        subject = member.built.subject
        for module in (subject.module, *([subject.types_module] if subject.has_types else [])):
            other = known.setdefault(module, member.type_name)
            if other != member.type_name:
                raise Refused(
                    f"{member.typed}: {module}.py would be of {other} and of {member.type_name}"
                )


def _beside(typed: str) -> str:
    return os.path.dirname(typed) if typed != STDIN else ""


def _places(beside: str, folders: Sequence[str]) -> list[str]:
    """Return where IDL files are looked for: in installed packages, too, but there last."""
    root = os.environ.get(_ROOT, "")
    places = [beside or ".", os.path.join(beside, _IDL), *folders]
    packages = (os.path.dirname(each.file) for each in installed().values())
    known = dict.fromkeys(os.path.join(each, _IDL) for each in packages)
    return [*places, root and os.path.join(root, "rtm", "idl"), *filter(os.path.isdir, known)]


def _member(
    typed: str, folders: Sequence[str], has_mirror: bool = False, folder: str = ""
) -> _Member:
    """Read a profile, that of stdin as if it lay in `folder`, and generate its component."""
    beside = folder if typed == STDIN else _beside(typed)
    idl = IdlFiles(_places(beside, folders))
    name, data = read_input(typed)
    reading = read_rtc(data, name)
    named = [path for name in idl_files(reading.profile) if (path := _path(idl, name))]
    definitions = _definitions(named, idl)
    more = _defining(undefined(reading.profile, definitions), idl)
    if more:
        definitions = _definitions([*named, *more], idl)
    names = tuple(os.path.basename(path) for path in idl.read)
    stem = os.path.basename(typed).partition(".")[0] if typed != STDIN else "Component"
    found = Sources(stem, definitions, _drawn(reading.profile, beside))
    built = build(reading.profile, found, names, has_mirror=has_mirror)
    remarks = [f"{typed}:{note.line}: {note.text}" for note in reading.notes]
    return _Member(typed, built, idl.read, more, remarks)


def _take(project: Project, member: _Member, profile: str) -> None:
    """Add the files of a component, with its profile under that name; by default its own."""
    files = dict(member.built.files)
    text = files.pop(PROFILE)
    profile = profile or f"{member.built.subject.module}.xml"
    if not _is_same(member.typed, os.path.join(project.folder, profile)):
        files[profile] = text
    for path, content in member.idl.items():
        files[f"{_IDL}/{os.path.basename(path)}"] = File(content)
    project.files |= files
    project.notes += member.built.notes
    project.notes += [
        f"{path}: not named by the profile; types are taken from it" for path in member.unnamed
    ]
    project.remarks += member.remarks


def present_profiles(folder: str) -> dict[str, str]:
    """Return the profiles of the components that were generated in a folder, by type name."""
    try:
        names = sorted(name for name in os.listdir(folder or ".") if name.endswith(".xml"))
    except OSError:
        return {}
    found: dict[str, str] = {}
    for name in sorted(names, key=lambda each: each != PROFILE):
        path = os.path.join(folder, name)
        type = _described(path)
        module = os.path.join(folder, f"{module_name(type_name(type, ''))}.py") if type else ""
        if module and type not in found and os.path.isfile(module):
            with open(module, encoding="utf-8", errors="replace") as stream:
                if stamp_of(stream.read(_HEAD)):
                    found[type] = path
    return found


def _other_type(file: str, own: str) -> str:
    """Return the type that a profile describes if it is another one than `own`."""
    found = _described(file)
    return found if found != own else ""


def _described(file: str) -> str:
    """Return the type that an RTC profile describes; empty for what is none."""
    try:
        data = read_bytes(file)
        info = read_rtc(data, file).profile.basic_info if may_be_component(data) else None
    except (InvalidDocument, NotFound):
        return ""
    return info.name if info is not None else ""


def _types_alone(typed: str, folder: str, idl: IdlFiles) -> Project:
    text = idl.text(typed)
    name = os.path.basename(typed)
    definitions = read_idl(text, typed, idl.find, KNOWN)
    built, notes = build_types(definitions, name)
    stock = [path for path in definitions.by_path if path in KNOWN]
    if stock and not built:
        notes.append(f"{typed}: {_built_in(stock)}; there is nothing to generate")
    elif not built:
        raise Refused(f"{typed}: nothing in it can be carried{_listed(notes)}")
    return Project(folder, built, notes=notes)


def _built_in(paths: Sequence[Path]) -> str:
    """Return where code finds types that rtkit has."""
    first = expression(paths[0])
    where = IMAGES if first.startswith("images.") else "from rtkit import component as rt"
    return f"its {len(paths)} types are built in ({where}; {first} …)"


def _listed(notes: Sequence[str]) -> str:
    return f": {'; '.join(notes)}" if notes else ""


def _definitions(paths: Iterable[str], idl: IdlFiles) -> Definitions:
    """Return the declarations of all IDL files together."""
    text = "".join(f'#include "{path}"\n' for path in dict.fromkeys(paths))
    return read_idl(text, "", lambda name, file: _included(idl, name, file), KNOWN)


def _defining(types: Sequence[str], idl: IdlFiles) -> list[str]:
    """Return the files, of those that no profile names, that declare these types.

    Real profiles often leave open where the types of their data ports are. A file that cannot be
    read is passed over: nobody asked for it.
    """
    found = []
    wanted = set(types)
    for path in idl.others() if types else ():
        tried = IdlFiles(idl.folders)
        try:
            declared = _definitions([path], tried)
        except (InvalidDocument, NotFound):
            continue
        here = {text for text in wanted if is_declared(text, declared)}
        if here:
            found.append(path)
            wanted -= here
    return found


def _path(idl: IdlFiles, name: str) -> str:
    found = idl.find(name)
    return found[0] if found else ""


def _included(idl: IdlFiles, name: str, file: str) -> tuple[str, str] | None:
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
