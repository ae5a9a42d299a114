"""``rtbuild``: generate a component from its RTC profile, or Python types from an IDL file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag, option, several
from rtkit.errors import Malformed, Refused

if TYPE_CHECKING:
    from rtkit.cli.profiles.generated_project import Project
    from rtkit.cli.profiles.project_changes import FileChange

_SHOWN = ("written", "kept")


@command(
    "rtbuild",
    is_local=True,
    examples=(
        ("rtbuild RTC.xml", "Generate a component beside its profile; again after each change."),
        ("rtbuild robot.yaml -o robot -I idl", "In a folder of its own, with IDL files of idl."),
        ("rtbuild Arm.xml Hand.xml -o arms", "Two components in one package."),
        ("rtbuild Wrist.xml -o arms --add", "One more component for it."),
        ("rtbuild --dry-run RTC.xml", "What would be written."),
        ("rtbuild --diff RTC.xml", "And how each file would change."),
        ("rtbuild MyService.idl -o src", "Only the types and protocols of an IDL file."),
    ),
    json=("built-file", "built-difference"),
)
def main(
    app: App,
    output: str | None = option(
        "-o --output DIR", "Where to write (default: the folder of the file)."
    ),
    folders: tuple[str, ...] = several("-I --include DIR", "Look for IDL files there too."),
    adds: bool = flag("--add", "Add to the components that the folder has."),
    has_mirror: bool = flag("--mirror", "Generate a mirror, too, to try it by hand."),
    dry_run: bool = flag("-n --dry-run", "Tell what would be written, write nothing."),
    force: bool = flag(
        "-f --force", "Write also what was changed; what was there is kept as NAME.bak."
    ),
    kept: tuple[str, ...] = several("--keep FILE", "Leave this file of the project as it is."),
    replaced: tuple[str, ...] = several(
        "--replace FILE", "Write this one as with --force, and no other that was changed."
    ),
    joined: tuple[str, ...] = several(
        "--merge FILE", "Merge what you changed in this one with what is new; keep NAME.bak."
    ),
    most_backups: int = option(
        "--backups COUNT",
        "So many NAME.bak of a file are kept, the latest; 0 for none (default 10).",
        click.IntRange(min=0),
        default=10,
    ),
    is_diff: bool = flag("--diff", "Show what would change in each file, write nothing."),
    is_json: bool = json_flag("A JSON object for each file."),
    files: tuple[str, ...] = arguments("PROFILE...|IDL"),
) -> None:
    r"""Generate components from their RTC profiles.

    Of an IDL file only Python types are generated.

    \b
    NAME.py             the component: ports, parameters, services, callbacks
    NAME_idl.py         types and protocols, where the profile names IDL files
    tests/test_NAME.py  a test of it
    README.md  pyproject.toml  system.xml  RTC.xml

    Several profiles become one package, named after the first component; the profiles of the
    others are NAME.xml. Each is an entry point, also in a pyproject.toml that you changed.

    Generating again keeps the code between "user code" marks, and whole files that are not code
    once they were changed. Changed code outside of the marks is a conflict: nothing is written.
    --merge brings both changes together, line by line, where the profile in the folder is still
    the one of which the file was generated: give the new profile as another file, or by stdin (-).

    A mirror (--mirror) is a component with each port reversed, mirror/NAMEMirror.py; rtresurrect
    mirror.xml, with a manager that was started in the folder of the project, connects both. It
    logs what arrives; what it sends, or how it serves, is for you to write, or to rtinject.

    IDL files are looked for where the profile says, beside it, in its folder idl, in the folders
    of -I, below $RTM_ROOT and in the installed packages of components.
    """
    from rtkit.cli.profiles import generated_project, project_changes

    if not files:
        raise Malformed("One RTC profile or IDL file has to be given.")
    project = generated_project.read(
        files, output, folders, has_mirror=has_mirror, adds=adds, is_forced=force
    )
    if project.other and not (force or adds):
        raise Refused(
            f"{project.folder or '.'} is the folder of component {project.other}:"
            " -o DIR gives this one its own, --add puts it beside that one"
        )
    changes = project_changes.compare(project)
    if is_diff or joined:
        changes = project_changes.with_three_way(project, changes)
    chosen = ((kept, project_changes.KEEP), (replaced, project_changes.REPLACE),
              (joined, project_changes.MERGE))  # fmt: skip
    choices = {name: choice for names, choice in chosen for name in names}
    changes = project_changes.decided(project, changes, choices)
    for note in project.remarks:
        app.verbose(note)
    for note in project.notes:
        app.report(f"note: {note}")
    if is_diff:
        _show(project, changes, is_json=is_json, is_forced=force)
        return
    conflicts = [each for each in changes if each.is_conflict]
    if conflicts and not force:
        for each in conflicts:
            app.fail(f"{each.path}:{each.merged.line}: {each.merged.why}")
        raise Refused(
            "nothing was written; --force writes, and keeps these as NAME.bak;"
            " --keep, --replace and --merge FILE decide for one"
        )
    if not dry_run:
        project_changes.write(changes, is_forced=force, most_backups=most_backups)
    _print(app, changes, is_json=is_json, is_forced=force)


def _show(
    project: Project, changes: Sequence[FileChange], *, is_json: bool, is_forced: bool
) -> None:
    """Show how each file would change; one that was changed, too, would be as it is written."""
    if is_json:
        terminal.write(json_records.lines("built-difference", (
            {
                "path": each.path,
                "name": name,
                "fate": each.assignment_when(is_forced=is_forced),
                "why": each.merged.why or None,
                "line": each.merged.line,
                "before": each.old,
                "after": each.text,
                "merged": each.three_way or None,
            }
            for name, each in zip(project.files, changes, strict=True)
        )))  # fmt: skip
        return
    from difflib import unified_diff

    for each in changes:
        before = (each.old or "").splitlines()
        lines = unified_diff(before, each.text.splitlines(), each.path, each.path, lineterm="")
        terminal.write(map(terminal.printable, lines))


def _print(app: App, changes: Sequence[FileChange], *, is_json: bool, is_forced: bool) -> None:
    if is_json:
        assignments = [each.assignment_when(is_forced=is_forced) for each in changes]
        records = (
            {"path": each.path, "fate": assignment, "why": each.merged.why or None}
            for each, assignment in zip(changes, assignments, strict=True)
        )
        terminal.write(json_records.lines("built-file", records))
        return
    for each in changes:
        assignment = each.assignment_when(is_forced=is_forced)
        if assignment in _SHOWN or app.is_verbose:
            why = f" ({each.merged.why})" if each.merged.why else ""
            click.echo(terminal.printable(f"{assignment:<9}  {each.path}{why}"))
