"""``rtattach``: the terminal of a component."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag, lasting, several
from rtkit.errors import Malformed, Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.api.attaching import TerminalClient

_READ_S = 2.0


@command(
    "rtattach",
    examples=(
        ("rtattach /localhost/ConsoleIn0.rtc", "Answer what it asks; Ctrl-] leaves it."),
        ("rtattach --send 5 /localhost/ConsoleIn0.rtc", "Send it a line, from a script."),
        ("rtattach /localhost/ConsoleIn0.rtc < answers.txt", "Send it the lines of a file."),
        ("rtattach --show /localhost/ConsoleIn0.rtc", "What it shows, and whether it waits."),
    ),
    json=("terminal",),
    arguments=("component",),
)
def main(
    app: App,
    sent: tuple[str, ...] = several("--send TEXT", "Send it a line, and end (repeatable)."),
    is_shown: bool = flag("--show", "Print what it shows and whether it waits, and end."),
    is_json: bool = json_flag("Of --show: as JSON."),
    timeout_s: float | None = lasting("How long sent lines may take to be read (default 2)."),
    paths: tuple[str, ...] = arguments("COMPONENT"),
) -> int:
    """Be at the terminal of a component: see what it asks, and answer.

    A component that reads from stdin has a terminal of its own, in its process. It waits there
    until somebody answers, and is shown as waiting for input. What it printed and asked meanwhile
    is shown at first. Ctrl-] leaves: the component goes on as it was. Several may be attached at
    once; all see the same, and all may type.

    With --send, or where stdin is no terminal, lines are sent and nothing is shown: the status is
    0 when the component has read all of them, 1 when it has not within the time; what is left
    stays there to be read. Ctrl-D at the beginning of a line is the end of its input, as in any
    terminal; Ctrl-C only takes back a line.
    """
    from rtkit.api.attaching import TerminalClient

    if not paths:
        raise Malformed("No component specified.")
    check_at_most_one(paths, "component")
    if sent and is_shown:
        raise UsageProblem("only one of --send and --show can be used")
    if is_json and not is_shown:
        raise UsageProblem("--json goes with --show")
    path = app.path(paths[0])
    facts = app.facts(path)
    is_typed = not sent and not is_shown and sys.stdin is not None and sys.stdin.isatty()
    if is_typed and terminal.is_terminal():
        from rtkit.cli.components.attached_screen import AttachedScreen

        client = TerminalClient(app.tree, facts.instance, is_attached=True)
        return AttachedScreen(app, client, paths[0]).run()
    client = TerminalClient(app.tree, facts.instance)
    if is_shown:
        identity = {"path": str(path), "component": facts.instance}
        return _show(app, client, identity if is_json else None)
    if is_typed:
        raise Refused("stdout is no terminal: --show prints what it shows, --send TEXT answers")
    lines = (each.encode() for each in sent) if sent else _lines_of_stdin()
    client.send(lines, _READ_S if timeout_s is None else timeout_s)
    return 0


def _show(app: App, client: TerminalClient, identity: dict[str, str] | None) -> int:
    answer = client.look()
    lines = answer.output.decode("utf-8", "replace").replace("\r\n", "\n").split("\n")
    lines = lines if lines[-1] else lines[:-1]
    if identity is not None:
        known = {"lines": lines, "waits": answer.waits, "unread_bytes": answer.unread}
        record = {**identity, **known, "attached": answer.others}
        terminal.write([json_records.line("terminal", record)])
        return 0
    terminal.write(map(terminal.printable, lines))
    if answer.waits:
        app.fail(answer.waits)
    return 0


def _lines_of_stdin() -> Iterator[bytes]:
    yield from sys.stdin.buffer if sys.stdin is not None else ()
