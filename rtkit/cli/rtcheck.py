"""``rtcheck``: compare the live system with a profile."""

from __future__ import annotations

import click

from rtkit.cli import _system
from rtkit.cli._app import App, command
from rtkit.rtc.enums import UNKNOWN_STATE, LifeCycleState

STATES = (*(state.value for state in LifeCycleState), UNKNOWN_STATE)


@command("rtcheck")
@click.option(
    "-s",
    "--state",
    type=click.Choice(STATES, case_sensitive=False),
    default=LifeCycleState.ACTIVE.value,
    help="State that every component is to be in (default Active).",
)
@click.option("--json", "is_json", is_flag=True, help="One JSON object a deviation, on stdout.")
@_system.system_options
def main(
    app: App,
    files: tuple[str, ...],
    state: str,
    is_json: bool,
    dry_run: bool,
    strict: bool,
    mapped: tuple[str, ...],
) -> int:
    """Compare the live system with an RTS profile (FILE, or stdin).

    Components, connections, active sets, parameters and states are compared, all of them; each
    deviation is a line on stderr. Exit status 1 when something required deviates.
    """
    from rtkit.deployment.check import check_lines, deviations
    from rtkit.deployment.live import Live
    from rtkit.errors import Refused

    profile = _system.read_profile(app, files, strict=strict)
    snapshot = _system.look(app, dry_run=dry_run)
    system = _system.wanted_system(app, profile, snapshot, mapped=mapped)
    if dry_run:
        for line in check_lines(system, state):
            click.echo(line)
        return 0
    expected = None if state == UNKNOWN_STATE else LifeCycleState(state)
    found = list(deviations(system, Live(snapshot, system), expected))
    for each in found:
        if is_json:
            import json

            record = {"kind": each.kind, "path": each.path, "text": each.text}
            record_line = {"schema": "rtkit.check/1", **record, "required": each.is_required}
            click.echo(json.dumps(record_line))
        else:
            app.say(each.text)
    return app.status(Refused()) if any(each.is_required for each in found) else 0
