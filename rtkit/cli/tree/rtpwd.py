"""``rtpwd``: print the working directory in the tree."""

from __future__ import annotations

import click

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments, working_directory
from rtkit.cli.shared.command import command


@command(
    "rtpwd",
    options_metavar="[OPTIONS]",
    examples=(
        ("rtpwd", "Print where relative paths start from."),
        ("rtpwd --json", "The same for another program."),
    ),
    json=("working-directory",),
    arguments=(),
)
@click.option("--json", "is_json", is_flag=True, help="One JSON object.")
@click.argument("words", nargs=-1, metavar="")
def main(app: App, words: tuple[str, ...], is_json: bool) -> None:
    """Print the working directory in the tree.

    It is what RTKIT_CWD says, else RTCSH_CWD, else the root.
    """
    if words:
        raise WrongArguments(f"takes no arguments: {' '.join(words)}")
    path = working_directory()
    record = {"path": path}
    terminal.write(
        [json_records.line("working-directory", record) if is_json else terminal.printable(path)]
    )
