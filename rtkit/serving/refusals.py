"""Logs denied requests: the first of each kind, then their number, so that nobody fills the log."""

from __future__ import annotations

import threading
from collections.abc import Callable
from logging import getLogger
from time import monotonic
from typing import NamedTuple

INTERVAL_S = 10.0
MOST = 20
"""Lines about one identity in an interval, above which the rest is counted."""
_MOST_KNOWN = 1000


class _Reported(NamedTuple):
    until: float
    lines: int
    more: int = 0
    last: str = ""


class Refusals:
    """Receives and logs denied requests; called under the lock of the host."""

    def __init__(self, log: Callable[[str], object] | None = None) -> None:
        self._log = log or (lambda line: getLogger("rtkit.properties").warning("%s", line))
        self._reported: dict[str, _Reported] = {}
        self._lock = threading.Lock()

    def __call__(self, identity: str, method: str, target: str) -> None:
        """Record a denied request."""
        what = f"{method} {target} by {identity!r}"
        with self._lock:
            now = monotonic()
            reported = self._reported.get(identity)
            if reported is None or now >= reported.until:
                self._summed(identity)
                if len(self._reported) >= _MOST_KNOWN:
                    self._reported.clear()
                reported = _Reported(now + INTERVAL_S, 0)
            if reported.lines < MOST:
                self._reported[identity] = reported._replace(lines=reported.lines + 1)
                self._log(f"denied: {what}")
                return
            if not reported.more:
                timer = threading.Timer(max(0.0, reported.until - now), self.sum_up, (identity,))
                timer.daemon = True
                timer.start()
            self._reported[identity] = reported._replace(more=reported.more + 1, last=what)

    def sum_up(self, identity: str) -> None:
        """Log the number of denials that were not logged one by one."""
        with self._lock:
            self._summed(identity)

    def _summed(self, identity: str) -> None:
        reported = self._reported.pop(identity, None)
        if reported is not None and reported.more:
            self._log(f"denied: {reported.more} more by {identity!r}, the last one {reported.last}")
