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
from rtkit.errors import InvalidDocument, Malformed, Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.api.planning import WayOptions


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
    statuses={
        "1": "The system is in none of its states, or it could not be done.",
    },
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
    the watching. What a profile with rtkit.follow=true describes is followed from rtapply,
    rtresurrect or rtstart on.
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
    from rtkit.api import following, planning
    from rtkit.api.states import states_of
    from rtkit.cli.system.states import as_lines, as_record
    from rtkit.deployment.planning.rendering import lines

    is_led = goto is not None or event is not None
    document = read_document(app, asked.files)
    if follow:
        following.check_one_manager(app, document)
    begun = planning.begin(
        app,
        document,
        asked.mapped,
        way,
        is_dry=dry_run,
        starts=is_led,
        lock=shared.locks(app, asked.files, wait_s) if is_led and not dry_run else None,
    )
    states, snapshot = states_of(begun), begun.snapshot
    if follow:
        from rtkit.cli.system.watching import Watching

        app.ask(following.owner(app))
        start = partial(following.begin, app, document, states, rolls_back=rollback)
        Watching(app, states.name, is_json=is_json).run(start, number)
        return 0
    followed = following.followed_in(snapshot, states.name)
    now = states.now(snapshot)
    if goto is None and event is None:
        ways = [states.way(state, snapshot) for state in states.machine.table]
        if is_json:
            terminal.write(
                [json_records.line("system-state", as_record(states, now, ways, followed))]
            )
        else:
            terminal.write(map(terminal.printable, as_lines(states, now, ways, followed)))
        return 0 if now else 1
    try:
        if event is None:
            target = states.machine.check_state(goto or "")
        elif not now:
            raise Malformed("the system is in none of its states; --goto leads it to one")
        else:
            target = states.machine.next(now, event)
    except Malformed as error:
        raise InvalidDocument(f"{begun.document.source}: {error}") from error
    if dry_run:
        goal = states.goal(target)
        terminal.write(map(terminal.printable, lines(goal.plan(snapshot), goal.costs)))
        return 0
    from rtkit.api.leading import leader
    from rtkit.deployment.states.leading import SystemTransition

    leading = leader(app, states, app.report, rolls_back=rollback)
    _, _, reached = leading.lead(SystemTransition(now, event or "goto", target))
    if reached != target:
        raise Refused(f"{target} was not reached; the system was led to {reached}")
    return 0


def _unfollow(app: App, files: tuple[str, ...], name: str) -> int:
    from rtkit.api import following, looking

    if files:
        raise UsageProblem("--unfollow takes the name of a system, and no FILE")
    app.report(following.end(app.tree, following.named(looking.snapshot(app), name)))
    return 0
