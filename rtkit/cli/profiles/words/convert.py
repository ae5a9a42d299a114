"""``rtprofile convert``: the same profile as XML, YAML or JSON."""

from __future__ import annotations

import click

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, option
from rtkit.errors import InvalidDocument, UsageProblem
from rtkit.profile.forms import FORMS, form_of_name

_FORM = click.Choice(FORMS)


@command(
    "convert",
    is_local=True,
    examples=(
        ("rtprofile convert robot.xml robot.yaml", "The same as YAML; also --to json."),
        ("rtprofile convert --to json robot.xml -", "As JSON, on stdout."),
    ),
)
def main(
    app: App,
    to: str | None = option("--to", "What to write; else as the name of OUTPUT ends.", _FORM),
    form: str | None = option("--from", "What it is; else as name and content say.", _FORM),
    files: tuple[str, ...] = arguments("INPUT [OUTPUT]"),
) -> int:
    """Write a profile as XML, YAML or JSON.

    INPUT may be - for stdin; without OUTPUT, or with -, the result goes to stdout. The result is
    read again before anything is put in place: it holds all that the profile says, or nothing is
    written. Comments are no part of a profile: that they are left out is told.
    """
    from rtkit.cli.profiles.document import read_bytes_of, report_findings
    from rtkit.link.atomic import write_output
    from rtkit.profile_tools.rewriting import rewritten
    from rtkit.report.finding import NOTE

    if not files:
        raise WrongArguments("No file specified.")
    if len(files) > 2:
        raise WrongArguments(f"takes an input and an output, not also: {' '.join(files[2:])}")
    output = files[1] if len(files) == 2 else "-"
    wanted = to or form_of_name(output)
    if wanted is None:
        raise UsageProblem(f"no form to write: --to {'|'.join(FORMS)}, or an OUTPUT that ends so")
    name, data = read_bytes_of(files[0])
    made = rewritten(data, name, form=form, to=wanted)
    shown = [each for each in made.findings if app.is_verbose or each.severity != NOTE]
    report_findings(app, shown)
    if made.data is None:
        return app.status(InvalidDocument())
    write_output(made.data, output)
    return 0
