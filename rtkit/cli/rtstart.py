"""``rtstart``: activate the system that a profile describes."""

from __future__ import annotations

import click

from rtkit.cli import _running, _system
from rtkit.cli._app import App, command


@command("rtstart")
@click.option("--no-wait", is_flag=True, help="Do not wait until each component is active.")
@_system.system_options
def main(
    app: App,
    files: tuple[str, ...],
    no_wait: bool,
    dry_run: bool,
    strict: bool,
    mapped: tuple[str, ...],
) -> None:
    """Activate every component of an RTS profile (FILE, or stdin), in its order.

    Each is active before the next is told. Required components must be there and must become
    active, else the rest is not begun.
    """
    from rtkit.deployment.running import active_now, start_plan

    profile = _system.read_profile(app, files, strict=strict)
    _running.run(
        app,
        profile,
        lambda system, live: start_plan(system, live, wait=not no_wait),
        dry_run=dry_run,
        mapped=mapped,
        tell=active_now,
    )
