"""``rtstop``: deactivate the system that a profile describes."""

from __future__ import annotations

import click

from rtkit.cli import _running, _system
from rtkit.cli._app import App, command


@command("rtstop")
@click.option("--no-wait", is_flag=True, help="Do not wait until each component is inactive.")
@_system.system_options
def main(
    app: App,
    files: tuple[str, ...],
    no_wait: bool,
    dry_run: bool,
    strict: bool,
    mapped: tuple[str, ...],
) -> None:
    """Deactivate every component of an RTS profile (FILE, or stdin), in reverse order.

    A component that is missing or refuses is reported; the others are stopped all the same.
    """
    from rtkit.deployment.running import active_now, stop_plan

    profile = _system.read_profile(app, files, strict=strict)
    _running.run(
        app,
        profile,
        lambda system, live: stop_plan(system, live, wait=not no_wait),
        dry_run=dry_run,
        mapped=mapped,
        tell=active_now,
    )
