"""``rtstop``: deactivate the system that a profile describes."""

from __future__ import annotations

from rtkit.api.starting import stop_plan_of
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import together
from rtkit.cli.system import shared, starting
from rtkit.cli.system.document import read_document


@command(
    "rtstop",
    examples=(
        ("rtstop robot.xml", "Deactivate them in reverse order."),
        ("rtstop --dry-run robot.xml", "Tell in which order."),
    ),
    json=("plan", "step"),
)
def main(
    app: App,
    no_wait: bool = starting.no_wait_flag("inactive"),
    draws: bool = starting.PLAN,
    is_json: bool = shared.PLAN_JSON,
    dry_run: bool = shared.DRY_RUN,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> None:
    """Deactivate every component of an RTS profile (FILE, or stdin), in reverse order.

    The order is that of the profile's Deactivation if there is one, else the reverse of the start.
    A component that is missing or refuses is reported; the others are stopped all the same. A
    component that waits for another one to be inactive does not wait for one that is in Error or
    gone.

    --timeout bounds a plan with conditions as a whole. Without it the plan ends when nothing has
    happened for 10 s after the last time that it names.
    """
    shared.watch(app, is_json=is_json)
    document = read_document(app, asked)
    starting.run(
        app,
        document,
        stop_plan_of(app, document, wait=not no_wait),
        draws=draws,
        dry_run=dry_run,
        may_lack=True,
    )
