"""Ctrl-C, from the first import to the last line: status 130 in a shell, never a traceback."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from rtkit.cli.shared.commands import COMMANDS

INTERRUPT = "import os, signal, sys; me = os.getpid(); os.kill(me, signal.SIGINT)"
LOAD = "import sys; sys.argv[0] = {script!r}; import rtkit.cli; "
COMMAND = """
import os, signal, sys
sys.argv[:] = ["/somewhere/rtwait"]
signal.signal(signal.SIGINT, {before})
from rtkit.cli.shared.command import command
@command("rtwait")
def main(app):
    {body}
sys.exit(main())
"""


def python(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("script", ["/usr/bin/rtls", "rtkit", "./rtmgr", *COMMANDS.values()])
def test_while_a_script_of_ours_imports(script: str) -> None:
    done = python(LOAD.format(script=script) + INTERRUPT)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def test_a_shell_sees_130_and_ends_its_loop() -> None:
    code = LOAD.format(script="rtls") + INTERRUPT
    line = f'{sys.executable} -c "{code}"; echo $?'
    done = subprocess.run(["sh", "-c", line], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("130\n", "")


@pytest.mark.parametrize(
    ("script", "before"), [("mine.py", "default_int_handler"), ("rtls", "SIG_IGN")]
)
def test_what_others_chose_is_left_alone(script: str, before: str) -> None:
    code = (
        f"import signal; signal.signal(signal.SIGINT, signal.{before}); "
        + LOAD.format(script=script)
        + f"assert signal.getsignal(signal.SIGINT) is signal.{before}"
    )
    assert python(code).stderr == ""


@pytest.mark.parametrize("before", ["signal.SIG_DFL", "signal.default_int_handler"])
def test_while_a_command_runs(before: str) -> None:
    body = "os.kill(os.getpid(), signal.SIGINT)"
    done = python(COMMAND.format(before=before, body=body))
    assert (done.returncode, done.stdout) == (-signal.SIGINT, "")
    assert done.stderr == "rtwait: interrupted\n"


def test_what_was_printed_before_is_not_lost() -> None:
    body = "print('x'); os.kill(os.getpid(), signal.SIGINT)"
    done = python(COMMAND.format(before="signal.SIG_DFL", body=body))
    assert (done.returncode, done.stdout) == (-signal.SIGINT, "x\n")


@pytest.mark.parametrize("moment_s", [1e-3, 1e-6])
def test_where_nothing_can_be_raised_from(moment_s: float) -> None:
    body = (
        "import threading; from rtkit.cli.shared import console_process\n"
        f"    console_process._MOMENT_S = {moment_s}\n"
        "    class Thing:\n"
        "        def __del__(self): os.kill(os.getpid(), signal.SIGINT)\n"
        "    Thing()\n"
        "    threading.Event().wait(60)\n"
        "    print('not interrupted')"
    )
    done = python(COMMAND.format(before="signal.SIG_DFL", body=body))
    assert (done.returncode, done.stdout) == (-signal.SIGINT, "")
    assert done.stderr == "rtwait: interrupted\n"


def test_nothing_comes_after_a_command() -> None:
    """Not even the end of the interpreter, which threads of the transport may disturb."""
    last = "import atexit; atexit.register(print, 'an orderly end'); "
    done = python(last + COMMAND.format(before="signal.SIG_DFL", body="print('x'); return 3"))
    assert (done.returncode, done.stdout, done.stderr) == (3, "x\n", "")


def test_ignored_interrupts_stay_ignored() -> None:
    body = "os.kill(os.getpid(), signal.SIGINT); print('done')"
    done = python(COMMAND.format(before="signal.SIG_IGN", body=body))
    assert (done.returncode, done.stdout, done.stderr) == (0, "done\n", "")
