"""``rtpwd``: print the working directory in the tree."""

from __future__ import annotations

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments, working_directory
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag


@command(
    "rtpwd",
    examples=(
        ("rtpwd", "Print where relative paths start from."),
        ("rtpwd --json", "The same for another program."),
    ),
    json=("working-directory",),
    arguments=(),
)
def main(
    app: App, is_json: bool = json_flag("One JSON object."), words: tuple[str, ...] = arguments("")
) -> None:
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
