"""Formats moments as the local time of day, for people."""

from __future__ import annotations

import time


def clock(moment: float) -> str:
    """Return the local time of day of a moment [s since 1970]: ``12:00:00.250``."""
    return f"{time.strftime('%H:%M:%S', time.localtime(moment))}.{int(moment % 1 * 1000):03}"
