"""Reports the start of a manager to its starter: warnings, failures, readiness; starts one again.

One line each, on the descriptor whose number is in the environment; without one, in the log. A
manager starts again in its own process: the same program, arguments and folder.
"""

from __future__ import annotations

import logging
import os
import re
import stat
import sys
from collections.abc import Mapping

from rtkit.errors import Malformed, Refused

READY_VARIABLE = "RTKIT_READY"
WANTED_VARIABLE = "RTKIT_WANTED"
"""Variable with the properties of the command line, for a daemon."""
READY = "ready"
WARNING = "warning "
FAILURE = "failure "
ERROR = "error "

_log = logging.getLogger(__name__)


class Report:
    """Reports to the process that waits for the start, until told that the start is over."""

    def __init__(self) -> None:
        number = os.environ.pop(READY_VARIABLE, "")
        self._descriptor = int(number) if number.isdigit() else None
        if self._descriptor is not None:
            os.set_inheritable(self._descriptor, False)

    @property
    def is_awaited(self) -> bool:
        """Return whether somebody waits."""
        return self._descriptor is not None

    def warn(self, text: str) -> None:
        """Report a warning."""
        _log.warning("%s", text)
        self._write(WARNING + text)

    def fail(self, what: str, why: str) -> None:
        """Report a failed step of the start."""
        _log.error("%s (%s)", what, why)
        self._write(f"{FAILURE}{what} ({why})")

    def ready(self) -> None:
        """Report that the manager answers, and that its start is over."""
        _log.info(READY)
        self._end(READY)

    def give_up(self, text: str) -> None:
        """Report why there will be no manager."""
        self._end(ERROR + text)

    def _end(self, text: str) -> None:
        self._write(text)
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def _write(self, text: str) -> None:
        if self._descriptor is None:
            return
        try:
            os.write(self._descriptor, text.replace("\n", " ").encode("utf-8", "replace") + b"\n")
        except BrokenPipeError:
            _log.warning("nobody waits for the start any more")


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


def execute_again(folder: str, report: int | None, more: Mapping[str, str]) -> None:
    """Become the same program anew; it reports on the descriptor `report` when it is ready.

    `more` are variables that were taken out of its environment.
    """
    environment = {**os.environ, **more}
    if report is not None:
        os.set_inheritable(report, True)
        environment[READY_VARIABLE] = str(report)
    os.chdir(folder)
    os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], environment)
