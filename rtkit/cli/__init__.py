"""Finds commands: one file a command, all of them in the generated `rtkit.cli.table`."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
import gc
import sys
from typing import TYPE_CHECKING

from rtkit.cli.table import TABLE

if TYPE_CHECKING:
    from rtkit.cli.shared.app import Main

COMMANDS: dict[str, str] = {name[2:]: name for name in TABLE if " " not in name}
"""Verb of the unified tool to the name of the command, of its console script and man page."""


_MANY = 50_000
"""New objects after which the collector of cycles looks at them; 700 are usual."""


def _begin_script() -> None:
    """Prepare this process for a console script; a plain import of a command changes nothing.

    Ctrl-C ends it without a traceback while it still imports. The module `signal` itself takes as
    long to import as all that comes before this. And what is imported lives until the end: to
    look through it for cycles again and again is a tenth of the time of a whole rtls
    (decision 35).
    """
    script = sys.argv[0].rpartition("/")[2] if sys.argv else ""
    if script != "rtkit" and script not in COMMANDS.values():
        return
    gc.set_threshold(_MANY, *gc.get_threshold()[1:])
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)


_begin_script()


def load(name: str) -> Main:
    """Import a command, by its name or its verb, ``rtprofile show`` too, and return it."""
    from importlib import import_module

    made: Main = import_module(TABLE[COMMANDS.get(name, name)][0]).main
    return made


def main() -> int:
    """Run ``rtkit VERB …``."""
    from rtkit.cli.unified import run

    return run()
