"""``rtstate``: the states of a system: which one it is in, and the way to another."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import COUNT, flag, json_flag, option, together
from rtkit.cli.system import shared
from rtkit.cli.system.document import read_document
from rtkit.cli.system.planning import WAY
from rtkit.errors import UsageProblem

if TYPE_CHECKING:
    from rtkit.api.planning import WayOptions
    from rtkit.api.states import StatesReport


@command(
    "rtstate",
    examples=(
        ("rtstate robot.xml", "Which state it is in, the way to each other, the events."),
        ("rtstate --goto dock robot.xml", "Lead it there, by the cheapest plan."),
        ("rtstate --event start robot.xml", "Lead it where this event leads."),
        ("rtstate --follow robot.xml", "Have its manager lead it on by events; watch."),
        ("rtstate --unfollow Robot", "Let its manager follow it no more."),
    ),
    json=("system-state", "transition"),
    statuses={"1": "The system is in none of its states, or it could not be done."},
)
def main(
    app: App,
    goto: str | None = option("-g --goto STATE", "Lead the system to this state."),
    event: str | None = option("-e --event EVENT", "Lead it to where this event leads."),
    follow: bool = flag(
        "-f --follow",
        "Have its manager lead it wherever its events lead, and watch until interrupted.",
    ),
    unfollow: str | None = option(
        "--unfollow NAME",
        "End that: the manager follows the system of this name, or identity, no more.",
    ),
    number: int | None = option(
        "-n --number N", "With --follow: watch until N transitions were made.", COUNT
    ),
    is_json: bool = json_flag("One JSON object."),
    rollback: bool = flag("--rollback", "When a step fails, go back to what was before."),
    wait_s: float = shared.WAIT,
    way: WayOptions = WAY,
    dry_run: bool = shared.DRY_RUN,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> int:
    """Show in which of its states a system is, or lead it to another (FILE, or stdin).

    A system profile may define states, what each asks for, and events that lead from one to
    another (rtkit help states). A system is in the state whose conditions all hold; that is seen,
    not remembered. The transition is the cheapest plan: what both states ask for is not touched.

    With --goto and --event managers of this host that do not run are started when needed; only one
    rtapply, rtresurrect or rtstate works at a manager at a time.

    A state that cannot be reached and has the event failed leads on by it; the status is 1 then.

    Without options the states are shown, with the way to each and the events of the present one;
    the status is 1 when the system is in none.

    With --follow the manager of the system follows its events from now on, also after its own
    restart, until --unfollow, rtteardown or a transition that fails without an event failed. The
    command only watches: each transition is told on stdout, and an interruption ends nothing but
    the watching. A system whose profile has rtkit.follow=true is followed from rtapply, rtresurrect
    or rtstart on.
    """
    if sum((goto is not None, event is not None, follow, unfollow is not None)) > 1:
        raise UsageProblem("--goto, --event, --follow and --unfollow exclude each other")
    if unfollow is not None:
        return _unfollow(app, asked.files, unfollow)
    if number is not None and not follow:
        raise UsageProblem("--number is for --follow")
    if is_json and (goto is not None or event is not None):
        raise UsageProblem("--json is for states and for --follow")
    if dry_run and follow:
        raise UsageProblem("--dry-run and --follow exclude each other")
    from rtkit.api import states

    is_led = goto is not None or event is not None
    document = read_document(app, asked)
    if follow:
        states.check_one_manager(app, document)
    lock = shared.locks(app, asked.files, wait_s) if is_led and not dry_run else None
    report = states.look(app, document, way, is_dry=dry_run, starts=is_led, lock=lock)
    if follow:
        from rtkit.cli.system.watching import Watching

        app.ask(states.owner(app))
        start = partial(states.follow, app, document, report.states, rolls_back=rollback)
        Watching(app, report.states.name, is_json=is_json).run(start, number)
    elif not is_led:
        return _show(report, is_json)
    elif dry_run:
        from rtkit.deployment.planning.rendering import lines

        goal = report.states.goal(report.target(goto or "", event or ""))
        terminal.write(map(terminal.printable, lines(goal.plan(report.live), goal.costs)))
    else:
        target = report.target(goto or "", event or "")
        states.lead(app, report, target, event or "", rolls_back=rollback)
    return 0


def _show(report: StatesReport, is_json: bool) -> int:
    from rtkit.cli.system.states import as_lines, as_record

    if is_json:
        terminal.write([json_records.line("system-state", as_record(report))])
    else:
        terminal.write(map(terminal.printable, as_lines(report)))
    return 0 if report.now else 1


def _unfollow(app: App, files: tuple[str, ...], name: str) -> int:
    from rtkit.api import looking, states

    if files:
        raise UsageProblem("--unfollow takes the name of a system, and no FILE")
    app.report(states.unfollow(app.tree, states.identity_of(looking.snapshot(app), name)))
    return 0
