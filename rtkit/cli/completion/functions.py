"""``rtkit shell-init SHELL``: the functions that a shell needs, to be evaluated by it."""

from __future__ import annotations

import os

from rtkit.cli.shared.commands import COMMANDS

SHELLS = ("bash", "zsh", "fish")
_FOLDER = os.path.join(os.path.dirname(__file__), "shells")

HELP = """\
Usage: {} shell-init bash|zsh|fish

Print the functions that a shell needs: rtcwd, and what completes commands at TAB. Put into
its start-up file:

  bash   eval "$(rtkit shell-init bash)"
  zsh    eval "$(rtkit shell-init zsh)"
  fish   rtkit shell-init fish | source"""


def script(shell: str) -> str:
    """Return the script that a shell must evaluate."""
    with open(os.path.join(_FOLDER, f"rtkit.{shell}"), encoding="utf-8") as file:
        return file.read().replace("@COMMANDS@", " ".join(["rtkit", *COMMANDS.values()])).rstrip()
