"""``rtpwd``: print the working directory in the tree."""

from __future__ import annotations

from rtkit.cli import _out
from rtkit.cli._app import App, command, working_directory


@command("rtpwd")
def main(app: App) -> None:
    """Print the working directory in the tree.

    It is what RTKIT_CWD says, else RTCSH_CWD, else the root.
    """
    _out.write([_out.printable(working_directory())])
