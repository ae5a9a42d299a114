"""Waits for descriptors to become readable, and for the reader of stdout to leave."""

from __future__ import annotations

import select
import sys
from collections.abc import Iterable
from time import monotonic

_GONE = select.POLLERR | select.POLLHUP | select.POLLNVAL


def wait_for(sources: Iterable[int], until: float | None) -> set[int]:
    """Wait until descriptors are readable and return those; none when the time is up.

    Args:
        sources: Descriptors to wait for.
        until: Deadline, monotonic [s]; None for none.

    Raises:
        BrokenPipeError: Nobody reads stdout any more.
    """
    poll = select.poll()
    out = _stdout()
    if out is not None:
        poll.register(out, 0)
    for each in sources:
        poll.register(each, select.POLLIN)
    wait_ms = None if until is None else max(0.0, until - monotonic()) * 1000
    ready = dict(poll.poll(wait_ms))
    if out is not None and ready.pop(out, 0) & _GONE:
        raise BrokenPipeError
    return set(ready)


def _stdout() -> int | None:
    try:
        return sys.stdout.fileno()
    except (OSError, ValueError):
        return None
