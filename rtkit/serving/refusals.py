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


class _Told(NamedTuple):
    until: float
    lines: int
    more: int = 0
    last: str = ""


class Refusals:
    """Receives and logs denied requests; called under the lock of the host."""

    def __init__(self, log: Callable[[str], object] | None = None) -> None:
        self._log = log or (lambda line: getLogger("rtkit.properties").warning("%s", line))
        self._told: dict[str, _Told] = {}
        self._lock = threading.Lock()

    def __call__(self, identity: str, method: str, target: str) -> None:
        """Record a denied request."""
        what = f"{method} {target} by {identity!r}"
        with self._lock:
            now = monotonic()
            told = self._told.get(identity)
            if told is None or now >= told.until:
                self._summed(identity)
                if len(self._told) >= _MOST_KNOWN:
                    self._told.clear()
                told = _Told(now + INTERVAL_S, 0)
            if told.lines < MOST:
                self._told[identity] = told._replace(lines=told.lines + 1)
                self._log(f"denied: {what}")
                return
            if not told.more:
                timer = threading.Timer(max(0.0, told.until - now), self.sum_up, (identity,))
                timer.daemon = True
                timer.start()
            self._told[identity] = told._replace(more=told.more + 1, last=what)

    def sum_up(self, identity: str) -> None:
        """Log the number of denials that were not logged one by one."""
        with self._lock:
            self._summed(identity)

    def _summed(self, identity: str) -> None:
        told = self._told.pop(identity, None)
        if told is not None and told.more:
            self._log(f"denied: {told.more} more by {identity!r}, the last one {told.last}")
