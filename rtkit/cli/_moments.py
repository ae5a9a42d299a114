"""Moments as text: in UTC for machines, as the time of day for people."""

from __future__ import annotations

import time
from datetime import datetime


def iso_time(moment: float) -> str:
    """Return a moment [s since 1970] as logs have it: ``2026-01-31T12:00:00.250000Z``."""
    whole, part = divmod(moment, 1)
    text = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(whole))
    return f"{text}.{int(part * 1e6):06}Z"


def clock_time(text: str) -> str:
    """Return the local time of day of such a moment: ``12:00:00.250``."""
    moment = datetime.fromisoformat(text).astimezone()
    return f"{moment:%H:%M:%S}.{moment.microsecond // 1000:03}"
