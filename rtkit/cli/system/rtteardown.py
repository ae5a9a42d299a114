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
    from rtkit.api.starting import teardown

    document = read_document(app, asked.files)
    plan = teardown(app, document, asked.mapped, ends_components=ends, is_dry=dry_run)
    if dry_run:
        shared.show(plan)
