"""``rtprofile check``: check systems against the RTC profiles of their components."""

from __future__ import annotations

from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag, strict_option
from rtkit.cli.shared.system_values import PARAMETERS
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
def main(
    app: App,
    components: tuple[str, ...] = static_checks.COMPONENTS,
    report: str | None = static_checks.REPORT,
    ignored: tuple[str, ...] = static_checks.IGNORED,
    strict: None = strict_option("Take warnings, and what needs repair, for errors."),
    is_json: bool = json_flag("The same as --format json."),
    forms: None = shared.READ_FORMS,
    quiet: bool = flag("-q --quiet", "Tell errors only."),
    parameters: None = PARAMETERS,
    paths: tuple[str, ...] = arguments("[SYSTEM|FOLDER|-]..."),
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
