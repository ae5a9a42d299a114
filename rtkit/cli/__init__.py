"""The commands. One file a command; `COMMANDS` is the static table of all of them."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
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


def _put_off_interrupts() -> None:
    """Have Ctrl-C end one of our scripts without a traceback while it still imports.

    The module `signal` itself takes as long to import as all that comes before this. What imports
    a command to call it is not touched.
    """
    script = sys.argv[0].rpartition("/")[2] if sys.argv else ""
    is_ours = script == "rtkit" or script in COMMANDS.values()
    if is_ours and _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)


_put_off_interrupts()


def main() -> int:
    """Run ``rtkit VERB …``."""
    from rtkit.cli._rtkit import run

    return run()
