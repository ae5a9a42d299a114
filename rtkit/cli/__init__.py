"""Lists the commands: one file a command, all of them in the static table `MODULES`."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
import gc
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rtkit.cli.shared.app import Main

MODULES: dict[str, str] = {
    "rtact": "rtkit.cli.components.rtact",
    "rtapply": "rtkit.cli.system.rtapply",
    "rtbuild": "rtkit.cli.profiles.rtbuild",
    "rtcat": "rtkit.cli.tree.rtcat",
    "rtcheck": "rtkit.cli.system.rtcheck",
    "rtcomp": "rtkit.cli.components.rtcomp",
    "rtcon": "rtkit.cli.components.rtcon",
    "rtconf": "rtkit.cli.components.rtconf",
    "rtcryo": "rtkit.cli.system.rtcryo",
    "rtcwd": "rtkit.cli.tree.rtcwd",
    "rtdeact": "rtkit.cli.components.rtdeact",
    "rtdel": "rtkit.cli.tree.rtdel",
    "rtdis": "rtkit.cli.components.rtdis",
    "rtdoc": "rtkit.cli.profiles.rtdoc",
    "rtdoctor": "rtkit.cli.managers.rtdoctor",
    "rtexit": "rtkit.cli.components.rtexit",
    "rtfind": "rtkit.cli.tree.rtfind",
    "rtfsm": "rtkit.cli.components.rtfsm",
    "rtget": "rtkit.cli.properties.rtget",
    "rtinject": "rtkit.cli.data.rtinject",
    "rtlisten": "rtkit.cli.properties.rtlisten",
    "rtlog": "rtkit.cli.data.rtlog",
    "rtls": "rtkit.cli.tree.rtls",
    "rtmgr": "rtkit.cli.managers.rtmgr",
    "rtplan": "rtkit.cli.system.rtplan",
    "rtprint": "rtkit.cli.data.rtprint",
    "rtprofile": "rtkit.cli.profiles.rtprofile",
    "rtproxy": "rtkit.cli.properties.rtproxy",
    "rtpwd": "rtkit.cli.tree.rtpwd",
    "rtreset": "rtkit.cli.components.rtreset",
    "rtresurrect": "rtkit.cli.system.rtresurrect",
    "rtserve": "rtkit.cli.properties.rtserve",
    "rtset": "rtkit.cli.properties.rtset",
    "rtstart": "rtkit.cli.system.rtstart",
    "rtstate": "rtkit.cli.system.rtstate",
    "rtstodot": "rtkit.cli.system.rtstodot",
    "rtstop": "rtkit.cli.system.rtstop",
    "rtteardown": "rtkit.cli.system.rtteardown",
    "rttop": "rtkit.cli.observing.rttop",
    "rtvlog": "rtkit.cli.observing.rtvlog",
    "rtwait": "rtkit.cli.observing.rtwait",
    "rtwatch": "rtkit.cli.observing.rtwatch",
}
"""Command to its module; the verb of `rtkit` is the name without ``rt``."""

COMMANDS: dict[str, str] = {name[2:]: name for name in MODULES}
"""Verb of the unified tool to the name of the command, of its console script and man page."""

_MANY = 50_000
"""New objects after which the collector of cycles looks at them; 700 are usual."""


def _begin_script() -> None:
    """Prepare this process for a console script; a plain import of a command changes nothing.

    Ctrl-C ends it without a traceback while it still imports. The module `signal` itself takes as
    long to import as all that comes before this. And what is imported lives until the end: to
    look through it for cycles again and again is a tenth of the time of a whole rtls.
    """
    script = sys.argv[0].rpartition("/")[2] if sys.argv else ""
    if script != "rtkit" and script not in COMMANDS.values():
        return
    gc.set_threshold(_MANY, *gc.get_threshold()[1:])
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)


_begin_script()


def load(name: str) -> Main:
    """Import a command, by its name or its verb, and return it."""
    from importlib import import_module

    made: Main = import_module(MODULES[COMMANDS.get(name, name)]).main
    return made


def main() -> int:
    """Run ``rtkit VERB …``."""
    from rtkit.cli.unified import run

    return run()
