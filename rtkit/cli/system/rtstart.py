"""``rtstart``: activate the system that a profile describes."""

from __future__ import annotations

from rtkit.api import states
from rtkit.api.starting import start_plan_of
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import together
from rtkit.cli.system import shared, starting
from rtkit.cli.system.document import read_document


@command(
    "rtstart",
    examples=(
        ("rtstart robot.xml", "Activate the components of a profile in its order."),
        ("rtstart --dry-run robot.xml", "Tell in which order, and what each waits for."),
        ("rtstart --plan robot.xml > robot.dot", "The same as a graph, for Graphviz."),
    ),
    json=("plan", "step"),
)
def main(
    app: App,
    no_wait: bool = starting.no_wait_flag("active"),
    draws: bool = starting.PLAN,
    is_json: bool = shared.PLAN_JSON,
    dry_run: bool = shared.DRY_RUN,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> None:
    """Activate every component of an RTS profile (FILE, or stdin), in its order.

    Each is active before the next is told, unless the profile's Activation says otherwise: by
    places in the order, waiting times, and components that come first. Required components must
    be there and must become active, else the rest is not begun; nor is it when a component that
    comes first is not ready in time.

    --timeout bounds a plan with such conditions as a whole. Without it the plan ends when nothing
    has happened for 10 s after the last time that it names.
    """
    shared.watch(app, is_json=is_json)
    document = read_document(app, asked)
    plan_for = start_plan_of(document, wait=not no_wait)
    is_followed = not (dry_run or draws) and states.is_follow_wanted(app, document)
    starting.run(app, document, plan_for, draws=draws, dry_run=dry_run)
    if is_followed:
        states.follow_now(app, document)
