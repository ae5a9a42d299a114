"""Generates all files of a component: takes its profile, returns texts by file name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from rtkit.builder.component_code import component_code
from rtkit.builder.identifiers import module_name
from rtkit.builder.mirror_component import FOLDER, listening, mirror_system, mirrored
from rtkit.builder.obstacles import obstacle
from rtkit.builder.packaging import pyproject
from rtkit.builder.prepare import Sources, prepare
from rtkit.builder.readme import readme
from rtkit.builder.regions import CODE_STAMP, XML_STAMP
from rtkit.builder.sample_system import sample_system
from rtkit.builder.standard_types import KNOWN
from rtkit.builder.subject import GeneratedComponent
from rtkit.builder.trial_code import trial_code
from rtkit.builder.types_code import TypesCode
from rtkit.idl.model import Definitions
from rtkit.profile.rtc_model import RtcProfile
from rtkit.profile.write import write_rtc

PROFILE = "RTC.xml"
PYPROJECT = "pyproject.toml"


class File(NamedTuple):
    """A generated file, not yet stamped.

    Attributes:
        has_regions: It has regions for code of users; else it is theirs once they change it.
    """

    text: str
    has_regions: bool = False


@dataclass(frozen=True, slots=True)
class Built:
    """Result of the generation.

    Attributes:
        files: By path within the project, ``/`` between folders.
        notes: Elements that could not be taken over as they are.
        has_idl: IDL files go with it.
        has_mirror: Its mirror does.
    """

    subject: GeneratedComponent
    files: dict[str, File]
    notes: tuple[str, ...]
    has_idl: bool = False
    has_mirror: bool = False


def build(
    profile: RtcProfile,
    sources: Sources,
    made_of: tuple[str, ...] = (),
    *,
    has_mirror: bool = False,
) -> Built:
    """Generate a component.

    Args:
        profile: Its RTC profile.
        sources: Files beside it.
        made_of: Names of the IDL files that were read.
        has_mirror: Also generate its mirror, and a system of both.

    Raises:
        Malformed: A text of the profile cannot be written to XML.
    """
    subject, types = prepare(profile, sources)
    module = subject.module
    files = {f"{module}.py": File(component_code(subject, types), has_regions=True)}
    if subject.has_types:
        text = types.text(made_of, [CODE_STAMP, ""])
        files[f"{subject.types_module}.py"] = File(text, has_regions=True)
    files[f"tests/test_{module}.py"] = File(trial_code(subject), has_regions=True)
    notes = subject.notes
    if has_mirror:
        mirror, more = _mirror(subject, sources, made_of)
        files |= more
        notes = tuple(dict.fromkeys([*notes, *mirror.notes]))
    built = Built(subject, files, notes, bool(made_of), has_mirror)
    files |= project_files([built])
    files[PROFILE] = File(_profile(profile))
    return built


def project_files(members: Sequence[Built]) -> dict[str, File]:
    """Return the files of a project that are about all its components, but for their profiles."""
    subjects = [each.subject for each in members]
    has_idl = any(each.has_idl for each in members)
    has_mirror = any(each.has_mirror for each in members)
    return {
        "README.md": File(readme(subjects)),
        PYPROJECT: File(pyproject(subjects, has_idl=has_idl, has_mirror=has_mirror)),
        "system.xml": File(sample_system(subjects)),
    }


def _mirror(
    subject: GeneratedComponent, sources: Sources, made_of: tuple[str, ...]
) -> tuple[GeneratedComponent, dict[str, File]]:
    """Return the mirror of a component, and the mirror's files."""
    found, types = prepare(mirrored(subject.profile, subject), replace(sources, drawn=None))
    mirror = replace(found, working=tuple(listening(found.ports)))
    code = File(component_code(mirror, types), has_regions=True)
    files = {f"{FOLDER}/{mirror.module}.py": code}
    if mirror.has_types:
        text = types.text(made_of, [CODE_STAMP, ""])
        files[f"{FOLDER}/{mirror.types_module}.py"] = File(text, has_regions=True)
    files[f"{FOLDER}.xml"] = File(mirror_system(subject, mirror))
    return mirror, files


def _profile(profile: RtcProfile) -> str:
    head, _, body = write_rtc(profile).decode().partition("\n")
    return f"{head}\n{XML_STAMP}\n{body}"


def build_types(definitions: Definitions, name: str) -> tuple[dict[str, File], list[str]]:
    """Return the module of the IDL declarations that rtkit can carry, and notes on all others.

    Args:
        definitions: Its declarations.
        name: Its name.
    """
    wanted, notes = [], []
    for path, declared in definitions.by_path.items():
        why = obstacle(definitions, declared)
        if why:
            notes.append(f"{declared.place}: {declared.name} is left out: {why}")
        elif path not in KNOWN:
            wanted.append(path)
    types = TypesCode(definitions, wanted)
    stem = module_name(name.rpartition("/")[2].rpartition(".")[0])
    text = types.text([name], [CODE_STAMP, ""])
    return ({f"{stem}_idl.py": File(text, has_regions=True)} if types else {}), notes
