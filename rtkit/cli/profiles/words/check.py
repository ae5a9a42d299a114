"""``rtprofile check``: check systems against the RTC profiles of their components."""

from __future__ import annotations

import click

from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command, strict_option
from rtkit.cli.system import shared, static_checks

TOOL = "rtprofile check"


@command(
    "check",
    is_local=True,
    examples=(
        ("rtprofile check robot.xml", "Do the components fit together?"),
        ("rtprofile check --format sarif robot.xml > found.sarif", "For a code host or an editor."),
    ),
    json=("checked",),
)
@static_checks.static_options
@strict_option("Take warnings, and what needs repair, for errors.")
@click.option("--json", "is_json", is_flag=True, help="The same as --format json.")
@shared.form_options("Read", "; without -x and -y, as name and content say", "yaml", "xml")
@click.option("-q", "--quiet", is_flag=True, help="Tell errors only.")
@click.argument("paths", nargs=-1, metavar="[SYSTEM|FOLDER|-]...")
def main(
    app: App,
    paths: tuple[str, ...],
    components: tuple[str, ...],
    report: str | None,
    ignored: tuple[str, ...],
    is_json: bool,
    quiet: bool,
) -> int:
    """Check systems against the RTC profiles of their components; nothing is run.

    Ports, directions, data types, service interfaces and who provides them, what connectors ask
    of ports, configuration parameters with their types and constraints, execution contexts,
    orders, names. RTC profiles are looked for in the folders given, $RTKIT_PROFILE_PATH, beside
    modules (here and in $RTKIT_MODULE_PATH), as rtc/*/RTC.xml of the repository of a system, and
    among those that ship; a component is known by vendor, category and name. One that is not is a
    warning. The exit status is 1 when there is an error.
    """
    from rtkit.static_check.verdict import Options

    form = "json" if is_json else report or static_checks.TEXT
    options = Options(app.is_strict, ignored, static_checks.this_host)
    return static_checks.check(
        app, paths, components, report=form, tool=TOOL, options=options, is_quiet=quiet
    )
