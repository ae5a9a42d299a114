"""``rtstatus``: tell on one page how a component, a slave or a manager is, and what happened."""

from __future__ import annotations

import click

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag, option
from rtkit.errors import Refused, Unreachable


@command(
    "rtstatus",
    examples=(
        ("rtstatus /localhost/Robot0.rtc", "A component: state, ports, events, log, crash."),
        ("rtstatus --json /localhost/manager.mgr", "A manager and its components, as JSON."),
        ("rtstatus -n 50 --no-rates Robot0.rtc", "More of the log, and at once."),
        ("rtstatus -q /localhost/Robot0.rtc", "Only the exit status: whether it is well."),
    ),
    json=("status",),
    arguments=("anything",),
    statuses={
        "1": "It is a zombie, in Error or in trouble, its manager does not run, or a host that the"
        " manager links cannot be reached."
    },
)
def main(
    app: App,
    is_json: bool = json_flag("One JSON object."),
    is_quiet: bool = flag("-q --quiet", "Print nothing: the exit status says it."),
    lines: int = option(
        "-n --lines N", "Lines of the log (default 10).", click.IntRange(min=0), default=10
    ),
    without_rates: bool = flag("--no-rates", "Do not measure rates, which takes a second."),
    paths: tuple[str, ...] = arguments("[PATH]"),
) -> int:
    r"""Tell on one page how a component is, and what happened to it.

    PATH is a component, a slave or a manager; by default the usual manager. Told are state, why
    and since when, process, rates, restarts, limits and health, ports with what they are connected
    to and values a second, warnings, the last events and lines of the log, and the last crash with
    its stack; of a manager also whether the hosts that it links can be reached.

    Where no manager runs, it tells what that left on the disk: how each component was, and how it
    ended. Of a crash the whole of all stacks is in rtvlog PATH.
    """
    from datetime import UTC, datetime

    from rtkit.cli.observing.status.gather import record_of
    from rtkit.cli.observing.status.page import page

    check_at_most_one(paths, "path")
    path = app.path(paths[0] if paths else f"/localhost/{app.manager}.mgr")
    has_rates = not (without_rates or is_quiet)
    record = record_of(app, path, lines, has_rates=has_rates)
    if is_json:
        terminal.write([json_records.line("status", record)])
    elif not is_quiet:
        terminal.write(page(record, datetime.now(UTC)))
    if record["is_well"]:
        return 0
    is_running = record["manager"]["is_running"]
    return app.status(Refused() if is_running else Unreachable())
