"""``rtcheck``: compare the live system with a profile."""

from __future__ import annotations

import click

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import flag, json_flag, option, together
from rtkit.cli.system import shared, static_checks
from rtkit.cli.system.document import read_document
from rtkit.errors import Refused, UsageProblem
from rtkit.rtc.enums import UNKNOWN_STATE, LifeCycleState

TOOL = "rtcheck --static"
STATES = (*(state.value for state in LifeCycleState), UNKNOWN_STATE)


@command(
    "rtcheck",
    examples=(
        ("rtcheck robot.xml", "Is everything there, connected, configured and active?"),
        ("rtcheck --diff robot.xml", "What the profile says, and what lives instead."),
        ("rtcheck -s inactive --json robot.xml", "Each deviation as JSON, for another program."),
    ),
    json=("deviation", "checked"),
    statuses={"1": "Something that is required deviates, or it could not be looked at."},
)
def main(
    app: App,
    state: str = option(
        "-s --state",
        "State that every component is to be in (default Active).",
        click.Choice(STATES, case_sensitive=False),
        default=LifeCycleState.ACTIVE.value,
    ),
    is_json: bool = json_flag("One JSON object a deviation: --format json."),
    is_junit: bool = flag("--junit", "The same as --format junit."),
    is_diff: bool = flag("--diff", "Both sides of each deviation, and what lives besides."),
    is_static: bool = flag(
        "--static", "Ask nobody: compare with RTC profiles, as rtprofile check does."
    ),
    components: tuple[str, ...] = static_checks.COMPONENTS,
    report: str | None = static_checks.REPORT,
    ignored: tuple[str, ...] = static_checks.IGNORED,
    dry_run: bool = shared.DRY_RUN,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> int:
    """Compare the live system with an RTS profile (FILE, or stdin).

    Components, connections, active sets, parameters and states are compared, all of them; each
    deviation is a line on stderr that tells what was found and what was wanted. Exit status 1 when
    something required deviates. --format writes to stdout for a build server instead; for JUnit
    each component and each connection is a test case. With --diff a line beginning with - tells
    what the profile says, one with + what lives; what lives besides is shown too, and is no
    deviation.

    With --static nothing that lives is asked: the components of the profile are compared with the
    RTC profiles of their types (see rtprofile check).
    """
    form = "json" if is_json else "junit" if is_junit else report or static_checks.TEXT
    if is_static:
        if is_diff or dry_run:
            raise UsageProblem("--static compares with no live system: no --diff, no --dry-run")
        check_at_most_one(asked.files, "file")
        from rtkit.static_check.verdict import Options

        options = Options(app.is_strict, ignored, static_checks.this_host)
        return static_checks.check(
            app, asked.files, components, report=form, tool=TOOL, options=options
        )
    if components or ignored:
        raise UsageProblem("--components and --ignore are for --static")
    if is_diff and form not in (static_checks.TEXT, "json"):
        raise UsageProblem("--diff has a form of its own, or that of --json: no --format")
    document = read_document(app, asked)
    if dry_run:
        from rtkit.api import looking
        from rtkit.api.displaced import where_they_live
        from rtkit.deployment.deviations import check_lines

        document = where_they_live(app, document)
        snapshot = looking.look(app, document, dry_run=True)
        system = looking.wanted_system(app, document, snapshot)
        for line in check_lines(system, state):
            click.echo(line)
        return 0
    from rtkit.api.checking import compare

    expected = None if state == UNKNOWN_STATE else LifeCycleState(state)
    report_of = compare(app, document, expected)
    system, live, found = report_of.system, report_of.live, report_of.found
    if is_diff:
        from rtkit.deployment.deviations import surplus

        found = (*found, *surplus(system, live))
    if is_diff and form == static_checks.TEXT:
        from rtkit.deployment.deviations import diff_lines

        terminal.write(map(terminal.printable, diff_lines(found)))
    elif form != static_checks.TEXT:
        from rtkit.cli.system.verdict import verdict_lines

        terminal.write(verdict_lines(form, document.source, system, found))
    elif found:
        from rtkit.cli.system.verdict import text_of

        for each in found:
            app.report(text_of(each))
    return 0 if report_of.holds else app.status(Refused())
