"""``rtopenrtm migrate``: convert sources of older versions of Python."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import unified_diff
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag
from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.openrtm.migrate.files import MigratedFile


@command(
    "migrate",
    is_local=True,
    examples=(
        ("rtopenrtm migrate ConsoleIn.py", "Convert it, with the files that it imports."),
        ("rtopenrtm migrate --dry-run *.py", "Only show what would change."),
    ),
    json=("migrated-file",),
    arguments=("file",),
)
def main(
    app: App,
    is_dry: bool = flag("-n --dry-run", "Write nothing."),
    is_json: bool = json_flag("A record for each file in place of the changes."),
    paths: tuple[str, ...] = arguments("FILE..."),
) -> int:
    """Convert Python 2 sources to Python 3, with what they import from beside them.

    The changes are shown, and the original of each file is kept as FILE.orig. All files are
    converted before one is written: where one cannot be, none is. A file that is Python 3 stays as
    it is, so a second time there is nothing to do.

    What 2to3 converts is converted by fissix; beyond that, whole numbers are divided as Python 2
    did where both are certainly whole, and unicode(x, ENCODING) takes x that is text already.
    In files of Python 2 and of older versions of 3 names that Python has lost since are replaced
    (time.clock, inspect.getargspec, string.join, collections.Mapping, async as a name ...), and in
    packages siblings are imported with a dot. What a person should look at is told, with its line.
    """
    from rtkit.openrtm.migrate.files import migrate, plan_migration

    if not paths:
        raise Malformed("No file specified.")
    plan = plan_migration(paths)
    kept = {} if is_dry else migrate(plan)
    for each in sorted(
        (*plan.files, *plan.others), key=lambda each: plan.looked_at.index(each.path)
    ):
        original = kept.get(each.path, "")
        if is_json:
            terminal.write([json_records.line("migrated-file", _record(each, original))])
        else:
            terminal.write(map(terminal.of_file, _changes(each)))
        _report(app, each, original)
    if not plan.files:
        count = len(plan.looked_at)
        app.fail(f"nothing to do: {count} file{'s are' if count > 1 else ' is'} Python 3")
    return 0


def _changes(file: MigratedFile) -> Iterator[str]:
    """Yield the changes of a file, in the form of ``diff -u``."""
    before, after = file.source.before.splitlines(), file.source.after.splitlines()
    yield from unified_diff(before, after, file.path, file.path, lineterm="")


def _report(app: App, file: MigratedFile, original: str) -> None:
    source, sign = file.source, file.source.sign
    version = "Python 2" if source.is_python2 else "an older Python"
    why = f"{version}: {sign.what}, line {sign.line}"
    whose = "; imported by the others" if file.beside else ""
    fate = f"converted; the original is {original}" if original else "would be converted"
    fate += "; tabs of indentation become spaces" * source.has_spaces
    if source.is_changed:
        app.fail(f"{file.path} ({why}{whose}): {fate}")
    for remark in file.source.remarks:
        app.fail(f"{file.path}:{remark.line}: look at it: {remark.text}")


def _record(file: MigratedFile, original: str) -> dict[str, object]:
    sign = file.source.sign
    return {
        "path": file.path,
        "why": sign.what,
        "line": sign.line,
        "is_imported": file.beside,
        "original": original or None,
        "changes": list(_changes(file)),
        "remarks": [{"line": each.line, "text": each.text} for each in file.source.remarks],
    }
