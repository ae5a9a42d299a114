"""``rtteardown``: remove the connections of a system and, with ``--exit``, its components."""

from __future__ import annotations

from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import flag, together
from rtkit.cli.system import shared
from rtkit.cli.system.document import read_document


@command(
    "rtteardown",
    examples=(
        ("rtteardown robot.xml", "Remove the connections of a profile."),
        ("rtteardown --exit robot.xml", "End its components too."),
    ),
)
def main(
    app: App,
    ends: bool = flag("--exit", "Also end the components, in reverse order."),
    dry_run: bool = shared.DRY_RUN,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> None:
    """Remove every connection of an RTS profile (FILE, or stdin).

    What is missing is reported; the rest is removed all the same. A system that its manager
    follows (rtstate) is followed no more.
    """
    from rtkit.deployment.live_index import LiveIndex
    from rtkit.deployment.running import left_now, teardown_plan

    document = read_document(app, asked.files)
    snapshot = shared.look(app, document.profile, dry_run=dry_run, may_lack=True)
    system = shared.wanted_system(app, document, snapshot, mapped=asked.mapped)
    if not dry_run:
        from rtkit.cli.system import following

        if following.end_if_followed(app, document, snapshot):
            snapshot = shared.remains(app)
    plan = teardown_plan(system, LiveIndex(snapshot, system), ends_components=ends)
    if dry_run:
        shared.show(plan)
        return
    from rtkit.cli.system import starting, step_times

    with (
        starting.reporting_progress(app, system, left_now),
        step_times.noting(app, system, snapshot) as taken,
    ):
        shared.runner(app, taken=taken).run(plan)
