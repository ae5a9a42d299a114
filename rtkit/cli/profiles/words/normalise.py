"""``rtprofile normalise``: profiles in the strict form, each repair told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import click

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, option
from rtkit.errors import InvalidDocument, Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.profile_tools.rewriting import Rewriting


class _Done(NamedTuple):
    """A document and its result."""

    name: str
    was: bytes
    rewriting: Rewriting


@command(
    "normalise",
    is_local=True,
    examples=(
        ("rtprofile normalise -i *.xml", "Put right in place what can be, and tell it."),
        ("rtprofile normalise --check robot.xml", "Would anything change?"),
    ),
)
def main(
    app: App,
    in_place: bool = flag("-i --in-place", "Replace the files."),
    output: str | None = option("-o --output FILE", "Where to write it (default stdout)."),
    check: bool = flag("--check", "Write nothing; status 1 if something would change."),
    quiet: bool = flag("-q --quiet", "Do not tell the repairs."),
    files: tuple[str, ...] = arguments("[FILE]..."),
) -> int:
    """Bring profiles to the strict form, and tell each repair.

    The result goes to stdout, to FILE or, with -i, in place of what was there: whole or not at
    all, and only if every one of the files can be repaired. XML stays XML, YAML stays YAML.
    """
    from rtkit.cli.profiles.document import report_findings
    from rtkit.link.atomic import write_output
    from rtkit.report.finding import NOTE

    _check(files, in_place=in_place, output=output, check=check)
    done = _rewritten(files or (None,))
    for each in done:
        findings = each.rewriting.findings
        report_findings(app, [f for f in findings if not (quiet and f.severity == NOTE)])
    if any(each.rewriting.data is None for each in done):
        if in_place and len(done) > 1:
            app.fail("nothing is written")
        return app.status(InvalidDocument())
    changed = [each for each in done if each.rewriting.data != each.was]
    if check:
        for each in changed:
            click.echo(f"{each.name}: would be changed")
        return app.status(Refused()) if changed else 0
    for each in changed if in_place else done:
        write_output(each.rewriting.data or b"", each.name if in_place else output or "-")
    return 0


def _check(files: Sequence[str], *, in_place: bool, output: str | None, check: bool) -> None:
    if sum((in_place, output is not None, check)) > 1:
        raise UsageProblem("only one of --in-place, --output and --check")
    if in_place and (not files or "-" in files):
        raise UsageProblem("--in-place needs a FILE")
    if len(files) > 1 and not (in_place or check):
        raise WrongArguments(f"several files need --in-place or --check: {files[1]}")


def _rewritten(files: Sequence[str | None]) -> list[_Done]:
    from rtkit.cli.profiles.document import read_bytes_of
    from rtkit.profile_tools.rewriting import rewritten

    done = []
    for file in files:
        name, data = read_bytes_of(file)
        done.append(_Done(name, data, rewritten(data, name, is_strict=True)))
    return done
