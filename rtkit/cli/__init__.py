"""Lists the commands: one file a command, all of them in the static table `COMMANDS`."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
import gc
import sys

COMMANDS: dict[str, str] = {
    "act": "rtact",
    "apply": "rtapply",
    "build": "rtbuild",
    "cat": "rtcat",
    "check": "rtcheck",
    "comp": "rtcomp",
    "con": "rtcon",
    "conf": "rtconf",
    "cryo": "rtcryo",
    "cwd": "rtcwd",
    "deact": "rtdeact",
    "del": "rtdel",
    "dis": "rtdis",
    "doc": "rtdoc",
    "doctor": "rtdoctor",
    "exit": "rtexit",
    "find": "rtfind",
    "fsm": "rtfsm",
    "get": "rtget",
    "inject": "rtinject",
    "listen": "rtlisten",
    "log": "rtlog",
    "ls": "rtls",
    "mgr": "rtmgr",
    "plan": "rtplan",
    "print": "rtprint",
    "profile": "rtprofile",
    "proxy": "rtproxy",
    "pwd": "rtpwd",
    "reset": "rtreset",
    "resurrect": "rtresurrect",
    "serve": "rtserve",
    "set": "rtset",
    "start": "rtstart",
    "state": "rtstate",
    "stodot": "rtstodot",
    "stop": "rtstop",
    "teardown": "rtteardown",
    "top": "rttop",
    "vlog": "rtvlog",
    "wait": "rtwait",
    "watch": "rtwatch",
}
"""Verb of the unified tool to the file, console script and man page of the command."""


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


def main() -> int:
    """Run ``rtkit VERB …``."""
    from rtkit.cli._rtkit import run

    return run()
