"""``rtplan``: the cheapest plan from the live system to a profile."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import flag, json_flag, option, together
from rtkit.cli.system import shared
from rtkit.cli.system.document import read_document
from rtkit.cli.system.planning import AIM
from rtkit.errors import UsageProblem

if TYPE_CHECKING:
    from rtkit.api.planning import GoalOptions

CHANGE_NEEDED = 2


@command(
    "rtplan",
    examples=(
        ("rtplan robot.xml", "What would be done, what it costs, what is kept."),
        ("rtplan --cost Motor0=1000 robot.xml", "Interrupt Motor0 only if nothing else will do."),
        ("rtplan --detailed-exitcode robot.xml", "Exit status 2 when something is to be changed."),
        ("rtplan --dot robot.xml", "What comes before what, as a graph."),
    ),
    json=("plan",),
    statuses={"2": "The command line cannot be read; with --detailed-exitcode: there are changes."},
)
def main(
    app: App,
    is_json: bool = json_flag("The plan as one JSON object."),
    is_dot: bool = flag("--dot", "The plan as a graph (dot)."),
    out: str | None = option(
        "--out FILE", "Save the plan, too; rtapply FILE carries out just this one."
    ),
    detailed_exitcode: bool = flag(
        "--detailed-exitcode", f"Exit status {CHANGE_NEEDED} when there is something to do."
    ),
    aim: GoalOptions = AIM,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> int:
    """Show the cheapest plan from the live system to an RTS profile (FILE, or stdin).

    Nothing is changed. Each step is shown with its cost and with what it changes; then which steps
    may be done at once, and what is kept. A setting that holds already takes no step: a parameter
    that may be changed while its component runs (rtkit.hot) is set without a stop, another by
    stopping that component and no other; one that moves is made anew with its connections.

    A step costs what steps of its kind took here, on a scale with the table, once 20 were measured;
    before, or with --costs table, what the table says (rtkit help plans). A profile may say what
    interrupting a component costs (rtkit.cost), and --cost goes before all.

    All that a profile says is compared: rates, policies and names, too, which are changed without a
    stop. A change that cannot be made in place is told, and is part of a plan with --replace only;
    components and connections that the profile does not name are removed with --prune only (rtkit
    help plans).

    Where there is no plan, the command tells which goals cannot hold together, and why; with
    --exit-detail the status is 7 then.
    """
    from rtkit.api import planning
    from rtkit.deployment.planning import rendering

    if is_json and is_dot:
        raise UsageProblem("--json and --dot exclude each other")
    document = read_document(app, asked, prunes=aim.prunes)
    prepared = planning.prepare(app, document, aim, is_dry=True)
    goal, plan = prepared.goal, prepared.plan
    if out is not None:
        from rtkit.api.saved_plan import save
        from rtkit.link.atomic import STDOUT

        if out == STDOUT:
            raise UsageProblem("--out needs a file: the plan itself is on stdout")
        save(out, document, prepared, planning.options_record(document, aim))
    if is_json:
        terminal.write([json_records.line("plan", rendering.as_plain(plan, goal.costs))])
    else:
        away = prepared.snapshot.unreachable
        lines = rendering.to_dot(plan) if is_dot else rendering.lines(plan, goal.costs, away)
        terminal.write(map(terminal.printable, lines))
    return CHANGE_NEEDED if detailed_exitcode and plan.moves else 0
