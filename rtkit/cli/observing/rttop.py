"""``rttop``: show what components do, live."""

from __future__ import annotations

import os

from rtkit.api.observers import Observers, scopes_of
from rtkit.api.rates import RateRow
from rtkit.cli.observing.top.activity import Top
from rtkit.cli.observing.top.page import TITLES, Look, ordered, table
from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import COUNT, WordChoice, arguments, flag, json_flag, option
from rtkit.rtc.names import LOCAL

_MOST_SKIPPED = 5
"""Number of first readings that are skipped while a process is missing in them."""


@command(
    "rttop",
    examples=(
        ("rttop", "All components of this host, live; h shows the keys."),
        ("rttop -s CPU% /localhost/manager.mgr", "Those of one manager, the busiest first."),
        ("rttop --once --json", "One look, for another program."),
    ),
    json=("activity",),
    arguments=("anything",),
)
def main(
    app: App,
    once: bool = flag("--once", "Show one page, after a second, and end."),
    number: int | None = option("-n --number N", "End after N pages.", COUNT),
    sort: str = option(
        "-s --sort COLUMN",
        f"Sort by {', '.join(TITLES)} (default NAME), or the beginning of one.",
        WordChoice("column", TITLES, is_short=True),
        default="NAME",
    ),
    reverse: bool = flag("--reverse", "Sort the other way round."),
    is_json: bool = json_flag("One JSON object a component, a line each."),
    paths: tuple[str, ...] = arguments("[PATH]..."),
) -> None:
    r"""Show what components do, live.

    PATH is a component, directory or manager; by default all of this host. On a terminal the page
    is kept up to date, and keys work, h shows which. In a pipe a page is written every second,
    nothing cut.

    \b
    RATE/Hz   cycles a second: reached / asked for; - where no cycle calls the component
    MEAN/ms   time of a cycle; MAX/ms of the longest one in the last second
    MISS/s    periods missed
    CPU% MEM  of the whole process, which several components may share
    IN/s      values read from in ports; OUT/s written to out ports
    RST       how often its policy made it again after it was lost (rtkit.restart)

    A line below a component tells why it is in Error, does not answer or is a zombie.
    """
    from rtkit.deployment.delta import TREE
    from rtkit.deployment.metrics import METRICS

    scopes = scopes_of(app, paths or (f"/{LOCAL}",))
    is_wide = not all(scope.is_one_manager for scope in scopes)
    look = Look(TITLES.index(sort), reverse)
    with Observers(app, (TREE, METRICS), is_wide=is_wide) as subscriptions:
        top = Top(app, subscriptions, scopes)
        if is_json or once or number or not _is_live():
            _write_pages(top, look, 1 if once else number, is_json=is_json)
        else:
            from rtkit.cli.observing.top.live import run

            run(top, look)


def _is_live() -> bool:
    return terminal.is_terminal() and os.environ.get("TERM", "dumb") != "dumb"


def _write_pages(top: Top, look: Look, number: int | None, *, is_json: bool) -> None:
    left, skips_left = number, _MOST_SKIPPED
    for events in top.subscriptions.listen(None):
        if not top.take(events) or not top.has_rates:
            continue
        if skips_left and not top.is_whole:
            skips_left -= 1
            continue
        skips_left = 0
        rows = ordered(top.rows(), look)
        if is_json:
            terminal.write_now([_json(row, top.time) for row in rows])
        else:
            gap = [""] if left != number else []
            terminal.write_now([*gap, top.summary(rows), *table(rows, look)])
        left = None if left is None else left - 1
        if left == 0:
            return
        left = left or -1


def _json(row: RateRow, moment: float) -> str:
    from rtkit.cli.shared.json_records import line, time_text

    path = row.path if row.path.startswith("/") else f"/{LOCAL}/{row.path}"
    fields = {"time": time_text(int(moment * 1e9)), **row._asdict(), "path": path}
    return line("activity", fields)
