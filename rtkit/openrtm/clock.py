"""Time as components of OpenRTM-aist ask for it."""

from __future__ import annotations

import time
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
    """The time at which it was made.

    Attributes:
        sec: Whole seconds since 1970 [s].
        usec: The rest [µs].
    """

    def __init__(self) -> None:
        self.sec, self.usec = divmod(time.time_ns() // 1000, _MICROSECONDS)

    def getTime(self) -> TimeValue:
        """Return the present time."""
        return self.gettimeofday()

    def gettimeofday(self) -> TimeValue:
        """Return the present time."""
        return TimeValue(0, time.time_ns() // 1000)
