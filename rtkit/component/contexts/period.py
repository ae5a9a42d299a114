"""Computes the deadlines at which a periodic execution context ticks.

Absolute deadlines on a fixed grid, in nanoseconds of a monotonic clock that the caller reads:
no drift however long it runs, and no burst after an overrun.
"""

from __future__ import annotations

import math

from rtkit.errors import Malformed

NANOSECONDS = 1_000_000_000


def check_rate(rate: float) -> float:
    """Return `rate` [Hz] if a periodic execution context can have it.

    Raises:
        Malformed: Not positive or not finite.
    """
    if not (rate > 0 and math.isfinite(rate)):
        raise Malformed(f"rate is not a positive number of Hz: {rate}")
    return rate


class Period:
    """The grid of deadlines of one periodic execution context.

    A tick that takes a period or more skips the deadlines that it lasts over: the next one is the
    first that is not yet past, so the phase is kept and others get their time. A tick that was in
    time by itself but began late has the last deadline that it lasts over made up for at once.

    Attributes:
        deadline_ns: When the next tick is due.
        skipped: Deadlines at which nothing was done: those skipped.
    """

    def __init__(self, rate: float, now_ns: int) -> None:
        self._rate = check_rate(rate)
        self._start_ns = now_ns
        self._index = 0
        self.deadline_ns = now_ns
        self.skipped = 0

    @property
    def rate(self) -> float:
        """Ticks per second [Hz]."""
        return self._rate

    def change_rate(self, rate: float, now_ns: int) -> None:
        """Start a new grid at `now_ns` with another rate [Hz].

        Raises:
            Malformed: Not positive or not finite.
        """
        self._rate = check_rate(rate)
        self.restart(now_ns)

    def restart(self, now_ns: int) -> None:
        """Start a new grid at `now_ns`, after a pause that is not an overrun."""
        self._start_ns = self.deadline_ns = now_ns
        self._index = 0

    def advance(self, now_ns: int, began_ns: int | None = None) -> int:
        """Return the next deadline, given that a tick from `began_ns` has just ended at `now_ns`.

        Without `began_ns` the tick counts as begun in time.
        """
        following = self._index + 1
        if self._at(following) < now_ns:
            elapsed = now_ns - self._start_ns
            later = max(following, math.floor(elapsed * self._rate / NANOSECONDS))
            while self._at(later) < now_ns:
                later += 1
            if began_ns is not None and (now_ns - began_ns) * self._rate < NANOSECONDS:
                later = max(following, later - 1)
            self.skipped += later - following
            following = later
        self._index = following
        self.deadline_ns = self._at(following)
        return self.deadline_ns

    def wait_s(self, now_ns: int) -> float:
        """Return the time until the next deadline [s], 0 when it is past."""
        return max(0, self.deadline_ns - now_ns) / NANOSECONDS

    def _at(self, index: int) -> int:
        return self._start_ns + math.ceil(index * NANOSECONDS / self._rate)
