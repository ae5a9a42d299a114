"""Compares the generated files of a project with those on disk, and writes them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rtkit.builder.component_files import PYPROJECT, File
from rtkit.builder.merge import Merged, MergeOutcome, merge
from rtkit.builder.packaging import ENTRY_POINTS, with_entries
from rtkit.builder.regions import stamped
from rtkit.builder.standard_types import KNOWN
from rtkit.builder.three_way import merged_file
from rtkit.cli.profiles.generated_project import IdlFiles, Project, present_profiles, read
from rtkit.errors import NotFound, Refused
from rtkit.idl.read import read_idl
from rtkit.link import backups
from rtkit.profile.read import read_bytes

KEEP, REPLACE, MERGE = "keep", "replace", "merge"
"""What a user may choose for one file: its own content, the generated one, or both in one."""


class FileChange(NamedTuple):
    """The change of one file.

    Attributes:
        path: Where it is.
        merged: What becomes of it by itself.
        old: Its present content; None where there is none, or none that is a text.
        three_way: It, with what is new in the generated one; "" where that cannot be told.
        choice: What the user has chosen for it; "" for nothing.
    """

    path: str
    merged: Merged
    old: str | None = None
    three_way: str = ""
    choice: str = ""

    @property
    def is_conflict(self) -> bool:
        """Return whether it cannot be written without losing something."""
        return not self.choice and self.merged.assignment is MergeOutcome.CONFLICT

    @property
    def is_changed(self) -> bool:
        """Return whether the user has changed what was generated."""
        return self.merged.assignment in (MergeOutcome.CONFLICT, MergeOutcome.KEEP)

    @property
    def text(self) -> str:
        """Return the content that it gets when it is written."""
        return self.three_way if self.choice == MERGE else self.merged.text

    def assignment_when(self, *, is_forced: bool) -> str:
        """Return the assignment of the file in a word."""
        if self.choice == KEEP:
            return MergeOutcome.KEEP.value
        if self.choice == MERGE and self.three_way == self.old:
            return MergeOutcome.SAME.value
        is_written = self.is_changed and (is_forced or self.choice in (REPLACE, MERGE))
        return (MergeOutcome.WRITE if is_written else self.merged.assignment).value


def compare(project: Project) -> list[FileChange]:
    """Return the change of each file.

    Raises:
        NotFound: A file that is there cannot be read.
    """
    changes = []
    for name, file in project.files.items():
        path = os.path.join(project.folder, *name.split("/"))
        merged = _merged(path, file)
        if name == PYPROJECT and merged.assignment is MergeOutcome.KEEP:
            merged = _entered(project, path, merged)
        changes.append(FileChange(path, merged, _text(path)))
    return changes


def with_three_way(project: Project, changes: Sequence[FileChange]) -> list[FileChange]:
    """Return the changes; those of files that were changed have the merge of both changes.

    What was generated before is generated again, from the profiles in the folder.
    """
    profiles = [*present_profiles(project.folder).values()]
    if not profiles or not any(each.is_changed for each in changes):
        return list(changes)
    earlier = read(profiles, project.folder, project.idl_folders).files
    found = []
    for each, (name, file) in zip(changes, project.files.items(), strict=True):
        base = earlier.get(name)
        if each.is_changed and base is not None and each.old is not None:
            before = stamped(base.text, has_regions=file.has_regions)
            new = stamped(file.text, has_regions=file.has_regions)
            text = merged_file(before, each.old, new, has_regions=file.has_regions)
            each = each._replace(three_way=text)
        found.append(each)
    return found


def decided(
    project: Project, changes: Sequence[FileChange], choices: Mapping[str, str]
) -> list[FileChange]:
    """Return the changes with what the user chose for some.

    Args:
        project: What they are of.
        changes: As `with_three_way` returns them where one is to be merged.
        choices: `KEEP`, `REPLACE` or `MERGE`, by the name of the file in the project.

    Raises:
        NotFound: No such file is generated.
        Refused: It cannot be merged.
    """
    names = list(project.files)
    found = list(changes)
    for name, choice in choices.items():
        if name not in names:
            raise NotFound(f"{name} is not generated; these are: {', '.join(names)}")
        change = found[names.index(name)]
        if choice == MERGE and change.is_changed and not change.three_way:
            raise Refused(
                f"{change.path} cannot be merged: the same lines are changed, or what it was"
                " generated from is not known any more"
            )
        found[names.index(name)] = change._replace(choice=choice)
    return found


def _text(path: str) -> str | None:
    try:
        return read_bytes(path).decode("utf-8").replace("\r\n", "\n")
    except (NotFound, UnicodeDecodeError):
        return None


def _entered(project: Project, path: str, merged: Merged) -> Merged:
    """Return the ``pyproject.toml`` of users with components that it does not name yet."""
    old = read_bytes(path).decode("utf-8", "replace")
    text = with_entries(old, project.entries)
    if not text:
        lines = "; ".join(project.entries.values())
        project.notes.append(f'{path}: yours; [project.entry-points."{ENTRY_POINTS}"]: {lines}')
    if text in ("", old):
        return merged
    return Merged(MergeOutcome.WRITE, text, "what is yours is kept")


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


def write(
    changes: Sequence[FileChange], *, is_forced: bool, most_backups: int = backups.MOST
) -> None:
    """Write all changed files, or none where one cannot be written.

    What was changed by users is kept as NAME.bak, NAME.bak2 …, `most_backups` of each file.
    """
    wanted = [
        each
        for each in changes
        if each.assignment_when(is_forced=is_forced) == MergeOutcome.WRITE.value
    ]
    staged: list[tuple[str, str]] = []
    try:
        for each in wanted:
            os.makedirs(os.path.dirname(each.path) or ".", exist_ok=True)
            staged.append((_stage(each.path, each.text), each.path))
        for each in wanted:
            if each.is_changed:
                backups.keep(each.path, most_backups)
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


def renew_types(idl: str) -> list[str]:
    """Make anew the types that were made of an IDL file; return what was written.

    They lie beside it, or above its folder ``idl``. If RTC profiles are there, they are theirs.

    Raises:
        InvalidDocument: The file is no IDL; tells the line.
        Refused: A file that is there was changed by hand.
    """
    folder = os.path.dirname(idl)
    home = os.path.dirname(folder) if os.path.basename(folder) == "idl" else folder
    read_idl(read_bytes(idl).decode("utf-8", "replace"), idl, IdlFiles([folder]).find, KNOWN)
    project = read([*present_profiles(home).values()] or [idl], home, [folder])
    changes = [
        each
        for each in compare(project)
        if each.path.endswith("_idl.py") and os.path.isfile(each.path)
    ]
    for each in changes:
        if each.is_conflict:
            raise Refused(f"{each.path}:{each.merged.line}: {each.merged.why}")
    write(changes, is_forced=False)
    wanted = MergeOutcome.WRITE.value
    return [each.path for each in changes if each.assignment_when(is_forced=False) == wanted]
