"""``rtteardown``: remove the connections, and the components, of a system."""

from __future__ import annotations

import click

from rtkit.cli import _running, _system
from rtkit.cli._app import App, command


@command("rtteardown")
@click.option("--exit", "ends", is_flag=True, help="Also end the components, in reverse order.")
@_system.system_options
def main(
    app: App,
    files: tuple[str, ...],
    ends: bool,
    dry_run: bool,
    strict: bool,
    mapped: tuple[str, ...],
) -> None:
    """Remove every connection of an RTS profile (FILE, or stdin).

    What is missing is reported; the rest is removed all the same.
    """
    from rtkit.deployment.running import left_now, teardown_plan

    profile = _system.read_profile(app, files, strict=strict)
    _running.run(
        app,
        profile,
        lambda system, live: teardown_plan(system, live, ends_components=ends),
        dry_run=dry_run,
        mapped=mapped,
        tell=left_now,
    )
