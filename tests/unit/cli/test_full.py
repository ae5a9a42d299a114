"""A stdout that takes nothing: one line and status 1, whatever command and whatever it says."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from rtkit.cli.shared.commands import COMMANDS, WORDS

LINES = [
    *(f"{name} {option}" for name in COMMANDS.values() for option in ("-h", "--version")),
    *(f"rtkit {verb} -h" for verb in (*COMMANDS, *WORDS)),
    "rtkit",
    "rtkit -h",
    "rtkit --version",
    "rtkit help",
    "rtkit help paths",
    "rtkit help statuses",
    "rtkit shell-init zsh",
    "rtkit complete zsh rtls --",
    "rtprofile show {root}/profiles/Motor.xml",
    "rtprofile validate {root}/profiles/Motor.xml",
    "rtpwd",
]
# Each line runs in a child of one process that has imported everything: a new one each would take
# a minute for what is here a second.
SCRIPT = """
import os, sys
from rtkit import cli
from rtkit.cli.shared.commands import COMMANDS, load
import rtkit.cli.completion.answer, rtkit.cli.completion.grammar
for name in COMMANDS.values():
    load(name)
for line in sys.stdin.read().splitlines():
    print(line, flush=True)
    read, write = os.pipe()
    pid = os.fork()
    if pid == 0:
        sys.argv = line.split()
        os.dup2(write, 2)
        if KIND == "full":
            os.dup2(os.open("/dev/full", os.O_WRONLY), 1)
        else:
            os.close(1)
            sys.stdout = sys.__stdout__ = None
        name = sys.argv[0]
        sys.exit(cli.main() if name == "rtkit" else load(name)())
    os.close(write)
    with open(read, "rb") as stream:
        told = stream.read()
    status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    print(status, told, flush=True)
"""


@pytest.mark.parametrize(
    ("kind", "why"), [("full", "No space left on device"), ("closed", "Bad file descriptor")]
)
def test_every_command_tells_it_in_one_line(kind: str, why: str) -> None:
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(__file__))))
    lines = [line.format(root=root) for line in LINES]
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT.replace("KIND", repr(kind))],
        input="\n".join(lines),
        capture_output=True,
        text=True,
        check=True,
    )
    told = done.stdout.splitlines()
    assert told[::2] == lines
    wrong = {}
    for line, outcome in zip(lines, told[1::2], strict=True):
        status, _, err = outcome.partition(" ")
        is_one_line = err.startswith("b'rt") and err.endswith(f": {why}\\n'")
        if status != "1" or not is_one_line or err.count("\\n") != 1:
            wrong[line] = outcome
    assert wrong == {}
    assert done.stderr == ""
