"""The commands. One file a command; `COMMANDS` is the static table of all of them."""

from __future__ import annotations

COMMANDS: dict[str, str] = {
    "act": "rtact",
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
    "exit": "rtexit",
    "find": "rtfind",
    "fsm": "rtfsm",
    "ls": "rtls",
    "mgr": "rtmgr",
    "pwd": "rtpwd",
    "reset": "rtreset",
    "resurrect": "rtresurrect",
    "start": "rtstart",
    "stop": "rtstop",
    "teardown": "rtteardown",
}
"""Verb of the unified tool to the file, console script and man page of the command."""


def main() -> int:
    """Run ``rtkit VERB …``."""
    from rtkit.cli._unified import run

    return run()
