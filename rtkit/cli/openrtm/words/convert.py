"""``rtopenrtm convert``: write the native equivalent of an old component."""

from __future__ import annotations

import os
from collections.abc import Iterator
from difflib import unified_diff
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag, option
from rtkit.errors import Refused

if TYPE_CHECKING:
    from rtkit.openrtm.convert.conversion import Conversion


@command(
    "convert",
    is_local=True,
    examples=(
        ("rtopenrtm convert ConsoleIn.py", "The native component, on stdout."),
        ("rtopenrtm convert --diff ConsoleIn.py", "What is other in it?"),
        ("rtopenrtm convert ConsoleIn.py -o native/ConsoleIn.py", "Write it beside the old one."),
    ),
    json=("converted-component",),
    arguments=("file",),
    statuses={"1": "Places need a hand, or nothing could be written."},
)
def main(
    app: App,
    output: str = option("-o --output FILE", "Where to write (default: stdout)."),
    is_forced: bool = flag("-f --force", "Write FILE even if it is there."),
    shows_diff: bool = flag("-d --diff", "Show the difference in place of the component."),
    is_json: bool = json_flag("A record of what was converted in place of the component."),
    paths: tuple[str, ...] = arguments("FILE"),
) -> int:
    """Write the native equivalent of a component for OpenRTM-aist-Python.

    Ports and parameters become typed declarations, callbacks get their native names, values are
    built where they are written; comments and layout of the author stay. Python 2, tabs and
    encodings are mended first, in memory. The old file is never written.

    What cannot be converted stays as it is, below a comment "# rtkit convert: REASON", and is
    told on stderr with its line in FILE. Exit status 0: nothing needs a hand, 1: something does.
    """
    from rtkit.openrtm.convert.conversion import convert
    from rtkit.openrtm.migrate.files import content_of

    if len(paths) != 1:
        raise WrongArguments("takes one file")
    path = paths[0]
    source = content_of(path)
    _check_output(output, path, is_forced=is_forced)
    made = convert(source, path)
    if output:
        _write(output, made.text)
    if is_json:
        terminal.write([json_records.line("converted-component", _record(path, output, made))])
    elif shows_diff:
        terminal.write(map(terminal.of_file, _difference(path, output, source, made)))
    elif not output:
        terminal.write(map(terminal.of_file, made.text.removesuffix("\n").split("\n")))
    for line, reason in [*made.marks, *made.remarks]:
        app.fail(f"{path}:{line}: {reason}")
    return app.status(Refused()) if made.marks else 0


def _check_output(output: str, path: str, *, is_forced: bool) -> None:
    """Refuse an output that would take the place of something."""
    if not output or not os.path.lexists(output):
        return
    if os.path.exists(output) and os.path.samefile(output, path):
        raise Refused(f"{output} is the old component: write to another file")
    if not is_forced:
        raise Refused(f"{output} is there already (--force writes it anew)")


def _write(output: str, text: str) -> None:
    from rtkit.link.atomic import write_output

    write_output(text.encode(), output)


def _difference(path: str, output: str, source: bytes, made: Conversion) -> Iterator[str]:
    """Yield the lines of ``diff -u`` from the old component to the native one."""
    from rtkit.openrtm.migrate.source import read_source

    before = read_source(source).text.splitlines()
    after = output or f"{os.path.splitext(path)[0]} (native)"
    yield from unified_diff(before, made.text.splitlines(), path, after, lineterm="")


def _record(path: str, output: str, made: Conversion) -> dict[str, object]:
    return {
        "path": path,
        "output": output or None,
        "components": list(made.components),
        "ports": made.ports,
        "parameters": made.parameters,
        "marks": [{"line": each.line, "reason": each.reason} for each in made.marks],
        "remarks": [{"line": line, "text": text} for line, text in made.remarks],
    }
