"""``rtpwd``: print the working directory in the tree."""

from __future__ import annotations

import click

from rtkit.cli import _out
from rtkit.cli._app import App, WrongArguments, command, working_directory


@command("rtpwd", options_metavar="[OPTIONS]")
@click.argument("words", nargs=-1, metavar="")
def main(app: App, words: tuple[str, ...]) -> None:
    """Print the working directory in the tree.

    It is what RTKIT_CWD says, else RTCSH_CWD, else the root.
    """
    if words:
        raise WrongArguments(f"takes no arguments: {' '.join(words)}")
    _out.write([_out.printable(working_directory())])
