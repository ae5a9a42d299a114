"""``rtdoctor``: what is wrong with this set-up, and what helps."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import NumberChoice, arguments, json_flag, option, strict_option
from rtkit.errors import Refused

if TYPE_CHECKING:
    from rtkit.cli.managers.doctor import Diagnosis

_PATIENCE_S = 0.4
_STYLES = {"ok": "green", "note": "blue", "warning": "yellow", "error": "bold red"}


@command(
    "rtdoctor",
    examples=(
        ("rtdoctor", "What is wrong, and what helps?"),
        ("rtdoctor --strict --json", "In a script: warnings fail too."),
    ),
    json=("diagnosis",),
    arguments=(),
    statuses={"1": "Something is wrong."},
)
def main(
    app: App,
    timeout_s: float = option(
        "--timeout SECONDS",
        f"How long to wait for each answer (default {_PATIENCE_S}).",
        NumberChoice(min=0.01),
        default=_PATIENCE_S,
    ),
    strict: None = strict_option("Let warnings fail too."),
    is_json: bool = json_flag("One JSON object for all that was looked at."),
    words: tuple[str, ...] = arguments(""),
) -> int:
    """Tell what is wrong with this set-up, and what helps.

    Looked at are versions, variables, limits, the clock, folders and their rights, keys and
    inventories of hosts and links to them, what killed processes left, TCP doors, managers, slaves
    and components; a large value is sent over a connection as it is made between two processes.
    Nothing is changed, and a manager that hangs holds nothing up. Things that are in order are told
    with -v only, and by --json; the exit status is 1 when something is wrong, which warnings and
    notes are not.
    """
    if words:
        raise WrongArguments(f"takes no arguments: {' '.join(words)}")
    found = list(_looked(timeout_s))
    if is_json:
        terminal.write(json_records.lines("diagnosis", map(_record, found)))
    else:
        terminal.write(_lines(found, is_all=app.is_verbose))
    fatal = ("error", "warning") if app.is_strict else ("error",)
    return app.status(Refused()) if any(each.severity in fatal for each in found) else 0


def _looked(timeout_s: float) -> Iterator[Diagnosis]:
    from rtkit.cli.managers.doctor import data_link, folders, installation, keys, live

    yield from installation.installation(os.environ)
    yield from data_link.data_link()
    yield from folders.folders()
    yield from keys.own_keys()
    yield from keys.hosts()
    if folders.is_trusted():
        yield from folders.remains()
        yield from folders.stores()
        yield from live.managers(timeout_s, os.environ)
        yield from live.links()
    yield from live.servers(os.environ, timeout_s)
    if sys.stdin is not None and sys.stdin.isatty() and terminal.is_terminal():
        yield installation.shell(os.environ, os.path.expanduser("~"))


def _record(each: Diagnosis) -> dict[str, object]:
    return {**each._asdict(), "cure": each.cure or None}


def _lines(found: Sequence[Diagnosis], *, is_all: bool) -> Iterator[str]:
    from rtkit.report.finding import counted

    for each in found:
        if each.severity == "ok" and not is_all:
            continue
        severity = terminal.styled(each.severity, _STYLES[each.severity])
        yield f"{severity}: {terminal.printable(each.text)}"
        if each.cure:
            yield f"  cure: {terminal.printable(each.cure)}"
    counts = {
        severity: sum(each.severity == severity for each in found)
        for severity in ("error", "warning", "note")
    }
    parts = [counted(n, word) for word, n in counts.items() if n]
    yield f"{len(found)} things looked at: {', '.join(parts) or 'all in order'}"
