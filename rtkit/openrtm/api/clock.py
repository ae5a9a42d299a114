"""Time as components of OpenRTM-aist ask for it."""

from __future__ import annotations

import time
from collections import deque
from typing import Any

_MICROSECONDS = 1_000_000
_NANOSECONDS = 1_000_000_000


def setTimestamp(data: Any) -> None:
    """Set the time stamp of a value to now."""
    data.tm.sec, data.tm.nsec = divmod(time.time_ns(), _NANOSECONDS)


class TimeValue:
    """A span of time, or a point in it.

    Attributes:
        tv_sec: Whole seconds [s].
        tv_usec: The rest, of the same sign [µs].
    """

    def __init__(self, sec: Any = None, usec: Any = None) -> None:
        whole = round(float(sec or 0) * _MICROSECONDS) + int(float(usec or 0))
        self._set(whole)

    def _set(self, microseconds: int) -> None:
        sign = -1 if microseconds < 0 else 1
        sec, usec = divmod(abs(microseconds), _MICROSECONDS)
        self.tv_sec, self.tv_usec = sign * sec, sign * usec

    @property
    def _whole(self) -> int:
        return self.tv_sec * _MICROSECONDS + self.tv_usec

    def __sub__(self, other: TimeValue) -> TimeValue:
        return TimeValue(0, self._whole - other._whole)

    def __add__(self, other: TimeValue) -> TimeValue:
        return TimeValue(0, self._whole + other._whole)

    def sec(self) -> int:
        """Return whole seconds [s]."""
        return self.tv_sec

    def usec(self) -> int:
        """Return the rest [µs]."""
        return self.tv_usec

    def set_time(self, seconds: float) -> TimeValue:
        """Set it [s]."""
        self._set(int(seconds * _MICROSECONDS))
        return self

    def toDouble(self) -> float:
        """Return it as a number [s]."""
        return self._whole / _MICROSECONDS

    def sign(self) -> int:
        """Return 1, 0 or -1."""
        return (self._whole > 0) - (self._whole < 0)

    def normalize(self) -> None:
        """Bring both parts to one sign."""
        self._set(self._whole)

    def __str__(self) -> str:
        return str(self.toDouble())


class Time:
    """The time at which it was made, or a difference of two.

    Attributes:
        sec: Whole seconds since 1970 [s].
        usec: The rest [µs].
    """

    def __init__(self) -> None:
        self.gettimeofday()

    def __sub__(self, other: Time) -> Time:
        difference = self.getTime() - other.getTime()
        made = Time()
        made.sec, made.usec = difference.tv_sec, difference.tv_usec
        return made

    def getTime(self) -> TimeValue:
        """Return it."""
        return TimeValue(self.sec, self.usec)

    def gettimeofday(self) -> TimeValue:
        """Set it to the present time, and return it."""
        self.sec, self.usec = divmod(time.time_ns() // 1000, _MICROSECONDS)
        return self.getTime()


class TimeMeasure:
    """Measures spans of time between calls of `tick` and `tack`.

    Args:
        buflen: How many spans count.
    """

    def __init__(self, buflen: int = 100) -> None:
        self._spans: deque[float] = deque(maxlen=buflen + 1)
        self._begin = 0.0

    def tick(self) -> None:
        """Begin a span."""
        self._begin = time.perf_counter()

    def tack(self) -> None:
        """End a span, if one has begun."""
        if self._begin:
            self._spans.append(time.perf_counter() - self._begin)

    def interval(self) -> TimeValue:
        """Return the last span."""
        return TimeValue(self._spans[-1] if self._spans else 0.0)

    def reset(self) -> None:
        """Forget all spans."""
        self._spans.clear()
        self._begin = 0.0

    def count(self) -> int:
        """Return how many spans count."""
        return len(self._spans)

    def getStatistics(self, *_: Any) -> tuple[bool, float, float, float, float]:
        """Return whether there are spans, the longest, the shortest, mean and deviation [s]."""
        if not self._spans:
            return False, 0.0, 0.0, 0.0, 0.0
        from statistics import fmean, pstdev

        deviation = pstdev(self._spans)
        return True, max(self._spans), min(self._spans), fmean(self._spans), deviation
