"""``rtteardown``: remove the connections of a system and, with ``--exit``, its components."""

from __future__ import annotations

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import flag, together
from rtkit.cli.system import shared
from rtkit.cli.system.document import read_document
from rtkit.errors import UsageProblem


@command(
    "rtteardown",
    examples=(
        ("rtteardown robot.xml", "Remove the connections of a profile."),
        ("rtteardown --exit robot.xml", "End its components too."),
        ("rtteardown --exit --uninstall robot.xml", "And remove what rtapply installed."),
    ),
    json=("plan", "step"),
)
def main(
    app: App,
    ends: bool = flag("--exit", "Also end the components, in reverse order."),
    uninstalls: bool = flag(
        "--uninstall", "With --exit, also packages that plans installed for it alone."
    ),
    wait_s: float = shared.wait_option(10.0),
    is_json: bool = shared.PLAN_JSON,
    dry_run: bool = shared.DRY_RUN,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> None:
    """Remove every connection of an RTS profile (FILE, or stdin).

    Missing parts are reported; the rest is removed all the same. A system that its manager follows
    (rtstate) is followed no more. Packages stay where another system was applied that needs them,
    or something that lives is of them.

    While rtapply, rtresurrect, rtmove, rtstate or an owner of movable components is at work at a
    manager, it waits for their end; what follows this system ends first.
    """
    from rtkit.api.starting import teardown

    shared.watch(app, is_json=is_json)
    document = read_document(app, asked)
    if uninstalls and not ends:
        raise UsageProblem("--uninstall goes with --exit: what lives needs its package")
    plan, more = teardown(
        app,
        document,
        ends_components=ends,
        uninstalls=uninstalls,
        is_dry=dry_run,
        lock=None if dry_run else shared.locks(app, asked.files, wait_s),
    )
    if dry_run and not is_json:
        shared.show(plan)
        terminal.write(more)
