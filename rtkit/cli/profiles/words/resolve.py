"""``rtprofile resolve``: a system profile with the values of its parameters in place."""

from __future__ import annotations

import click

from rtkit.cli.shared import system_values
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, option, strict_option
from rtkit.cli.shared.system_values import PARAMETERS
from rtkit.profile.forms import FORMS, XML, form_of_name


@command(
    "resolve",
    is_local=True,
    examples=(
        ("rtprofile resolve --set Sensor0.range=3 robot.xml", "The plain profile with a value."),
        ("rtprofile resolve --prefix a. robot.xml a.yaml", "All its names behind a., as YAML."),
    ),
)
def main(
    app: App,
    to: str | None = option(
        "--to", "What to write; else as the name of OUTPUT ends, else XML.", click.Choice(FORMS)
    ),
    strict: None = strict_option("Refuse a profile that needs repair."),
    parameters: None = PARAMETERS,
    files: tuple[str, ...] = arguments("[INPUT [OUTPUT]]"),
) -> None:
    """Write a system profile with the values of its parameters in place.

    Variables, conditions and includes are replaced by what they mean. So each command sees a
    profile with the same --set, --values and --prefix, and so other tools can read it. INPUT may
    be - for stdin; without OUTPUT the result goes to stdout.
    See rtkit help parameters.
    """
    from rtkit.api.system_profiles import read_parametrised
    from rtkit.cli.profiles.document import read_bytes_of
    from rtkit.link.atomic import STDOUT, write_output
    from rtkit.profile.write import write_profile

    if len(files) > 2:
        raise WrongArguments(f"takes an input and an output, not also: {' '.join(files[2:])}")
    name, data = read_bytes_of(files[0] if files else None)
    found = read_parametrised(app, name, data, None, system_values.parameters(app))
    output = files[1] if len(files) == 2 else STDOUT
    write_output(write_profile(found.profile, to or form_of_name(output) or XML), output)
