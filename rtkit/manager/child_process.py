"""Child processes of a manager: how one ended, and the back-off of its restarts."""

from __future__ import annotations

import os

STOPS = (os.CLD_STOPPED, os.CLD_TRAPPED)
ENDS = (os.CLD_EXITED, os.CLD_KILLED, os.CLD_DUMPED)
"""Codes of reports by `os.waitid`: a child has stopped, or has ended."""

_FIRST_S = 0.1
_MOST_S = 10.0
_HEALTH_S = 30.0
"""Who has run for so long, or has done its work, ended by accident [s]."""


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
