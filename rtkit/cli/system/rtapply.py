"""``rtapply``: make the live system what a profile says, by the cheapest plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from rtkit.api.system_profiles import is_saved_plan, parse_document
from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import COUNT, flag, option, together
from rtkit.cli.shared.system_values import parameters
from rtkit.cli.system import shared
from rtkit.cli.system.document import as_asked, read_data
from rtkit.cli.system.planning import AIM
from rtkit.errors import Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.api.planning import GoalOptions


@command(
    "rtapply",
    examples=(
        ("rtapply robot.xml", "Create, connect, set and activate just what is not so yet."),
        ("rtapply --rollback robot.xml", "Come back to what was before if a step fails."),
        ("rtapply -s inactive --parallel 4 robot.xml", "Activate nothing, at most four at once."),
    ),
    json=("plan", "step"),
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
    aim: GoalOptions = AIM,
    is_json: bool = shared.PLAN_JSON,
    dry_run: bool = shared.DRY_RUN,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> int:
    """Make the live system what an RTS profile says (FILE, or stdin).

    It is done by the plan that rtplan shows. FILE may also be a plan that rtplan --out saved. Just
    that plan is carried out, if everything is as it was when the plan was made; else nothing is
    done, and what has changed is told. Where something turns out otherwise on the way it stops,
    instead of planning anew.

    Nothing that holds already is touched. Steps that need nothing of each other are done at once,
    and the live system is looked at before each round: if something turned out otherwise, the rest
    is planned anew. When a step fails nothing more is begun, and what is left is told; run again,
    it goes on from there. With --rollback it goes back instead, by the cheapest way; what fails on
    that way is told, and the rest goes back all the same. So it is with --strict, where a step that
    is done with a note has failed.

    Managers that do not run and are needed are started first, as rtmgr start does; those of hosts
    that rthost knows, which paths name, /robot1/Motor0.rtc, as rtmgr start --host does.
    Only one rtapply, rtresurrect, rtteardown or rtstate works at a manager at a time; another one
    names it and ends, or waits with --wait.

    A parameter or set that a component does not have is told; when all else is done the exit status
    is 1 then, as that of rtcheck.

    --timeout bounds each step. Steps are told on stderr when they are done, and what they took is
    noted: plans made later count with it.
    """
    from rtkit.api import planning
    from rtkit.api.plan import carry_out
    from rtkit.deployment.planning.rendering import as_plain, lines

    shared.watch(app, is_json=is_json)
    source, data = read_data(asked.files)
    is_saved = is_saved_plan(data)
    lock = None if dry_run else shared.locks(app, asked.files, wait_s)
    if is_saved:
        from rtkit.api import saved_plan

        inputs = saved_plan.opened(data, source)
        _check_nothing_else(app, inputs.options)
        prepared = saved_plan.prepare(
            app, inputs, is_dry=dry_run, parallel=parallel or 0, lock=lock
        )
    else:
        document = parse_document(app, source, data, app.form, parameters(app))
        document = as_asked(app, document, asked, prunes=aim.prunes)
        prepared = planning.prepare(
            app, document, aim, is_dry=dry_run, parallel=parallel or 0, lock=lock
        )
    if dry_run and app.watch is not None:
        app.watch.plan(as_plain(prepared.plan, prepared.goal.costs))
        return 0
    if dry_run:
        away = prepared.snapshot.unreachable
        terminal.write(map(terminal.printable, lines(prepared.plan, prepared.goal.costs, away)))
        return 0
    unmet = carry_out(app, prepared, rolls_back=rollback or app.is_strict, is_exact=is_saved)
    return app.status(Refused()) if unmet else 0


def _check_nothing_else(app: App, options: dict[str, Any]) -> None:
    """Refuse options that were settled when the plan was made."""
    context = click.get_current_context()
    given = [
        parameter.opts[-1]
        for parameter in context.command.params
        if parameter.name in (*options, "placed", "left_out", "sets", "values", "prefix")
        and context.get_parameter_source(parameter.name) is ParameterSource.COMMANDLINE
    ]
    given += [f"--{app.form}"] if app.form is not None else []
    if given:
        raise UsageProblem(f"{', '.join(given)}: settled already where the plan is a saved one")
