"""``rtcwd``: print the line by which a shell changes the working directory in the tree."""

from __future__ import annotations

import os
import re

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, check_at_most_one, working_directory
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments
from rtkit.errors import NotFound, Refused

_PLAIN = re.compile(r"[\w/.:+-]*", re.ASCII)
_C_SHELLS = ("csh", "tcsh")
_IN_SHELL = str.maketrans({"'": r"'\''"})
_IN_C_SHELL = str.maketrans({"'": r"'\''", "!": r"\!"})
_IN_FISH = str.maketrans({"'": r"\'", "\\": r"\\"})


@command(
    "rtcwd",
    examples=(
        ("rtcwd /localhost/robot.host_cxt", "Print the line that a shell is to evaluate."),
        ("rtcwd ..", "One level up. What the shell function does, and rtkit shell-init defines."),
    ),
    arguments=("directory",),
)
def main(app: App, paths: tuple[str, ...] = arguments("[PATH]")) -> None:
    """Change the working directory in the tree.

    A program cannot change the environment of the shell that started it: this one prints the
    line to be evaluated, in the syntax of the shell that SHELL names. The function rtcwd that
    "rtkit shell-init" defines evaluates it. Without a path: the root.
    """
    check_at_most_one(paths, "path")
    terminal.write([_line(_place(app, paths[0] if paths else "/"))])


def _place(app: App, typed: str) -> str:
    from rtkit.tree.resolve import find

    path = app.path(typed)
    if path.port is not None:
        raise Refused(f"Not a directory: {path.typed}")
    if not path.elements:
        return "/"
    node = app.node(find, path)
    if node is None:
        raise NotFound(f"Not a directory: {path.typed}")
    if not node.is_directory:
        raise Refused(f"Not a directory: {path.typed}")
    is_kept = typed == "." and working_directory().endswith("/")
    return f"{path}/" if typed.endswith("/") or is_kept else str(path)


def _line(place: str) -> str:
    # A variable that is set already would take precedence over the one that scripts know.
    variable = "RTKIT_CWD" if os.environ.get("RTKIT_CWD") else "RTCSH_CWD"
    shell = os.path.basename(os.environ.get("SHELL", ""))
    if shell in _C_SHELLS:
        return f"setenv {variable} {_quoted(place, _IN_C_SHELL)}"
    if shell == "fish":
        return f"set -gx {variable} {_quoted(place, _IN_FISH)}"
    return f"export {variable}={_quoted(place, _IN_SHELL)}"


def _quoted(text: str, escapes: dict[int, str]) -> str:
    """Return `text` so that a shell takes nothing in it for its own."""
    return f'"{text}"' if _PLAIN.fullmatch(text) else f"'{text.translate(escapes)}'"
