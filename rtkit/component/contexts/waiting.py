"""Grants callbacks the waits that their connectors allow, which do not count as being stuck.

The driver of callbacks on a thread registers a function that grants the present callback more
time. A bounded wait of a port is granted its bound and returns the unused rest. Where values
follow each other closely most waits end at once: those are granted after they end, many at a
time, because one grant takes longer than all other work on a value.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import TIMEOUT_MAX, get_ident

_LONGEST_S = 3600.0
"""Longest wait that is granted [s]: a callback in an unbounded wait counts as stuck."""

_ENDLESS_NS = 10 * 365 * 86_400 * 1_000_000_000
"""Grant of a wait for people, who may have left for the day [ns]."""

_BRIEF_S = 0.005
"""Length of a wait that needs no grant beforehand [s]: a fraction of any kept deadline."""
_OWED_NS = 1_000_000
"""Largest sum of ended waits whose grant is still postponed [ns]."""


class DrivenThread:
    """A thread whose callbacks are driven under a watchdog.

    Attributes:
        grant: Grants the present callback more time [ns].
        owed_ns: Waits that are over and were not granted yet [ns].
        idle_ns: Waits for people, or for one another, that are over: no work, and no period was
            missed by them [ns].
    """

    __slots__ = ("grant", "idle_ns", "owed_ns")

    def __init__(self, grant: Callable[[int], object]) -> None:
        self.grant = grant
        self.owed_ns = 0
        self.idle_ns = 0

    def take_idle_ns(self) -> int:
        """Return how long it was idle since this was asked last [ns]."""
        idle_ns, self.idle_ns = self.idle_ns, 0
        return idle_ns


_driven: dict[int, DrivenThread] = {}


def grant_by(grant: Callable[[int], object] | None) -> DrivenThread | None:
    """Register a function that grants callbacks on this thread more time [ns]; None: remove it."""
    if grant is None:
        _driven.pop(get_ident(), None)
        return None
    driven = _driven[get_ident()] = DrivenThread(grant)
    return driven


@contextmanager
def waiting(bound_s: float, *, is_idle: bool = False) -> Iterator[None]:
    """Grant the present callback a wait of at most `bound_s` [s].

    No period counts as missed by one that is idle.
    """
    driven = _driven.get(get_ident())
    if driven is None or bound_s > _LONGEST_S:
        yield
        return
    granted_ns, began_ns = int(bound_s * 1e9), time.monotonic_ns()
    driven.grant(granted_ns)
    try:
        yield
    finally:
        waited_ns = time.monotonic_ns() - began_ns
        driven.grant(waited_ns - granted_ns)
        if is_idle:
            driven.idle_ns += waited_ns


@contextmanager
def waiting_for_people() -> Iterator[None]:
    """Grant the present callback any time until somebody has answered it."""
    driven = _driven.get(get_ident())
    if driven is None:
        yield
        return
    began_ns = time.monotonic_ns()
    driven.grant(_ENDLESS_NS)
    try:
        yield
    finally:
        waited_ns = time.monotonic_ns() - began_ns
        driven.grant(waited_ns - _ENDLESS_NS)
        driven.idle_ns += waited_ns


def wait_for(wait: Callable[[float], bool], bound_s: float) -> float:
    """Wait at most `bound_s` [s]; return the rest of that bound [s].

    `wait` does so for a time [s] and returns whether what is waited for has come.
    """
    began_ns = time.monotonic_ns()
    is_there = wait(min(bound_s, _BRIEF_S))
    waited_ns = time.monotonic_ns() - began_ns
    driven = _driven.get(get_ident())
    if driven is not None:
        driven.owed_ns += waited_ns
        if driven.owed_ns > _OWED_NS:
            driven.grant(driven.owed_ns)
            driven.owed_ns = 0
    left_s = bound_s - waited_ns / 1e9
    if is_there or left_s <= 0:
        return left_s
    with waiting(left_s):
        wait(min(left_s, TIMEOUT_MAX))
    return bound_s - (time.monotonic_ns() - began_ns) / 1e9
