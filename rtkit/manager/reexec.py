"""Starts a manager again in its own process: the same program, arguments and folder."""

from __future__ import annotations

import os
import re
import stat
import sys

from rtkit.errors import Malformed, Refused
from rtkit.manager.report import READY_VARIABLE

_PIPE = re.compile(r"/proc/(\d+)/fd/(\d+)")


def open_report(path: str) -> int | None:
    """Open the pipe of a client that waits for the restart, ``/proc/PID/fd/N``.

    Raises:
        Malformed: It names something else.
        Refused: It cannot be opened, or is no pipe.
    """
    if not path:
        return None
    if _PIPE.fullmatch(path) is None:
        raise Malformed(f"not the pipe of a process: {path}")
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    except OSError as error:
        raise Refused(f"cannot open {path}: {error.strerror}") from error
    if not stat.S_ISFIFO(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise Refused(f"not a pipe: {path}")
    return descriptor


def execute_again(folder: str, report: int | None) -> None:
    """Become the same program anew; it reports on the descriptor `report` when it is ready."""
    environment = dict(os.environ)
    if report is not None:
        os.set_inheritable(report, True)
        environment[READY_VARIABLE] = str(report)
    os.chdir(folder)
    os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], environment)
