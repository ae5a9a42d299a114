"""Waits that a callback is allowed by its connectors: they do not count as being stuck.

Whoever drives callbacks on a thread says how the present one is granted more time; a wait of a
port with a bound grants itself that bound, and gives back what it did not need. Where values
follow each other closely most waits are over at once: those are granted when they are over, and
many at a time, for a grant would take longer than what a value needs otherwise.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import TIMEOUT_MAX, Lock, get_ident

_LONGEST_S = 3600.0
"""The longest wait that is granted: who may wait for ever is stuck when he does [s]."""

_BRIEF_S = 0.005
"""How long one may wait before it is granted that: a fraction of any deadline that is kept [s]."""
_OWED_NS = 1_000_000
"""How much of waits that are over is granted later at most [ns]."""


class _Driven:
    """A thread on which somebody drives callbacks.

    Attributes:
        grant: Grants the present callback more time [ns].
        owed_ns: Waits that are over and were not granted yet [ns].
    """

    __slots__ = ("grant", "owed_ns")

    def __init__(self, grant: Callable[[int], object]) -> None:
        self.grant = grant
        self.owed_ns = 0


_driven: dict[int, _Driven] = {}


def grant_by(grant: Callable[[int], object] | None) -> None:
    """Have callbacks on this thread granted more time [ns] by that; None for no longer."""
    if grant is None:
        _driven.pop(get_ident(), None)
    else:
        _driven[get_ident()] = _Driven(grant)


@contextmanager
def waiting(bound_s: float) -> Iterator[None]:
    """Grant the present callback a wait of at most `bound_s` [s]."""
    driven = _driven.get(get_ident())
    if driven is None or bound_s > _LONGEST_S:
        yield
        return
    granted_ns, began_ns = int(bound_s * 1e9), time.monotonic_ns()
    driven.grant(granted_ns)
    try:
        yield
    finally:
        driven.grant(time.monotonic_ns() - began_ns - granted_ns)


def wait_for(wakeup: Lock, bound_s: float) -> float:
    """Wait until somebody releases `wakeup`, at most `bound_s` [s]; return what is left of that."""
    began_ns = time.monotonic_ns()
    is_rung = wakeup.acquire(timeout=min(bound_s, _BRIEF_S))
    waited_ns = time.monotonic_ns() - began_ns
    driven = _driven.get(get_ident())
    if driven is not None:
        driven.owed_ns += waited_ns
        if driven.owed_ns > _OWED_NS:
            driven.grant(driven.owed_ns)
            driven.owed_ns = 0
    left_s = bound_s - waited_ns / 1e9
    if is_rung or left_s <= 0:
        return left_s
    with waiting(left_s):
        wakeup.acquire(timeout=min(left_s, TIMEOUT_MAX))
    return bound_s - (time.monotonic_ns() - began_ns) / 1e9
