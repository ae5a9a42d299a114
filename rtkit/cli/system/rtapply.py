"""``rtapply``: make the live system what a profile says, by the cheapest plan."""

from __future__ import annotations

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import COUNT, flag, option, together
from rtkit.cli.system import following, planning, shared, step_times
from rtkit.cli.system.document import is_saved_plan, parse_document, read_data
from rtkit.errors import Refused


@command(
    "rtapply",
    examples=(
        ("rtapply robot.xml", "Create, connect, set and activate just what is not so yet."),
        ("rtapply --rollback robot.xml", "Come back to what was before if a step fails."),
        ("rtapply -s inactive --parallel 4 robot.xml", "Activate nothing, at most four at once."),
    ),
)
def main(
    app: App,
    rollback: bool = flag("--rollback", "When a step fails, go back to what was before."),
    parallel: int | None = option(
        "--parallel COUNT",
        "Most steps under way at once (default: all that need nothing of each other).",
        COUNT,
    ),
    wait_s: float = shared.WAIT,
    aim: planning.GoalOptions = together(planning.GoalOptions),
    dry_run: bool = shared.DRY_RUN,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> int:
    """Make the live system what an RTS profile says (FILE, or stdin).

    It is done by the plan that rtplan shows. FILE may also be a plan that rtplan --out saved. Just
    that plan is carried out, if everything is as it was when the plan was made; else nothing is
    done, and what has changed is told. Where something turns out otherwise on the way it stops,
    instead of planning anew.

    What holds already is not touched. Steps that need nothing of each other are done at once, and
    what lives is looked at before each round: what turned out otherwise is planned anew. When a
    step fails nothing more is begun, and what is left is told; run again, it goes on from there.
    With --rollback it goes back instead, by the cheapest way; what fails on that way is told, and
    the rest goes back all the same. So it is with --strict, where a step that is done with a note
    has failed.

    Managers of this host that do not run and are needed are started first, as rtmgr start does.
    Only one rtapply, rtresurrect or rtstate works at a manager at a time; another one names
    it and ends, or waits with --wait.

    What a component does not have, a parameter or a set, is told; when all else is done the exit
    status is 1 then, as that of rtcheck.

    --timeout bounds each step. Steps are told on stderr when they are done, and what they took is
    noted: plans made later count with it.
    """
    from rtkit.deployment.applying import Applier
    from rtkit.deployment.planning.rendering import lines
    from rtkit.tree.grace import uninterrupted

    source, data = read_data(asked.files)
    is_saved = is_saved_plan(data)
    lock = None if dry_run else shared.locks(app, asked.files, wait_s)
    if is_saved:
        from rtkit.cli.system import saving

        prepared = saving.prepare(
            app, data, source, is_dry=dry_run, parallel=parallel or 0, lock=lock
        )
    else:
        document = parse_document(app, source, data)
        prepared = planning.prepare(
            app, document, asked.mapped, aim, is_dry=dry_run, parallel=parallel or 0, lock=lock
        )
    document, goal, snapshot, plan, survey = prepared
    is_followed = not dry_run and following.is_wanted(document)
    if dry_run:
        terminal.write(map(terminal.printable, lines(plan, goal.costs)))
        return 0
    with step_times.noting(app, goal.system, snapshot) as taken:
        applier = Applier(app.tree, goal, app.report, app.report, taken, survey, uninterrupted)
        applier.run(plan, snapshot, rolls_back=rollback or app.is_strict, is_exact=is_saved)
    if is_followed:
        following.begin_from(app, document, goal)
    return app.status(Refused()) if applier.unmet else 0
