"""Child processes of a manager: what they inherit, how one ended, the back-off of its restarts."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress

MARK = "RTKIT_MANAGER_PROCESS"
"""Environment variable of what components in a manager's own process start: whose it is."""

ENDS_WITH = "RTKIT_ENDS_WITH"
"""Environment variable of managers: the process with which they end, ``PID`` or ``PID:BEGAN``."""

_FIRST = 3  # those before are input, output and error

STOPS = (os.CLD_STOPPED, os.CLD_TRAPPED)
ENDS = (os.CLD_EXITED, os.CLD_KILLED, os.CLD_DUMPED)
"""Codes of reports by `os.waitid`: a child has stopped, or has ended."""

_FIRST_S = 0.1
_MOST_S = 10.0
_HEALTH_S = 30.0
"""A process that has run for so long, or has done its work, ended by accident [s]."""


def unmarked(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without the mark, for what is to outlive the manager."""
    return {key: value for key, value in environment.items() if key != MARK}


def withhold() -> None:
    """Have programs that are started from here inherit nothing that this one was given.

    Descriptors that this process opened itself are not inherited anyway; but a script may have
    handed it the lock it holds, or a pipe whose end somebody waits for, and a process that outlives
    the script would keep them.
    """
    for name in os.listdir("/proc/self/fd"):
        descriptor = int(name)
        if descriptor >= _FIRST:
            with suppress(OSError):  # the one by which the folder was read
                os.set_inheritable(descriptor, False)


class Backoff:
    """Counts ends in succession; time comes in as an argument, monotonic [s].

    The first start after an accident is at once, the next after 0.1 s, then each after twice the
    time, up to 10 s.

    Attributes:
        failures: How many times in succession it has ended soon.
    """

    def __init__(self) -> None:
        self.failures = 0
        self._began = 0.0
        self._is_proven = False

    def begin(self, now: float) -> None:
        """Note that it is started."""
        self._began, self._is_proven = now, False

    def prove(self) -> None:
        """Note that it has done what it is there for."""
        self._is_proven = True

    def end(self, now: float) -> float:
        """Note that it ended; return how long to wait until it is started again [s]."""
        if self._is_proven or now - self._began >= _HEALTH_S:
            self.failures = 0
        self.failures += 1
        if self.failures == 1:
            return 0.0
        return min(_FIRST_S * 2.0 ** min(self.failures - 2, 30), _MOST_S)


def exit_reason(report: os.waitid_result) -> str:
    """Return how a process ended: ``signal 9`` or ``exit status 3``."""
    if report.si_code == os.CLD_EXITED:
        return f"exit status {report.si_status}"
    return f"signal {report.si_status}"
