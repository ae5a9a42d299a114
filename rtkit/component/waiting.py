"""Waits that a callback is allowed by its connectors: they do not count as being stuck.

Whoever drives callbacks on a thread says how the present one is granted more time; a wait of a
port with a bound grants itself that bound, and gives back what it did not need.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import get_ident

_LONGEST_S = 3600.0
"""The longest wait that is granted: who may wait for ever is stuck when he does [s]."""

_grants: dict[int, Callable[[int], object]] = {}


def grant_by(grant: Callable[[int], object] | None) -> None:
    """Have callbacks on this thread granted more time [ns] by that; None for no longer."""
    if grant is None:
        _grants.pop(get_ident(), None)
    else:
        _grants[get_ident()] = grant


@contextmanager
def waiting(bound_s: float) -> Iterator[None]:
    """Grant the present callback a wait of at most `bound_s` [s]."""
    grant = _grants.get(get_ident())
    if grant is None or bound_s > _LONGEST_S:
        yield
        return
    granted_ns, began_ns = int(bound_s * 1e9), time.monotonic_ns()
    grant(granted_ns)
    try:
        yield
    finally:
        grant(time.monotonic_ns() - began_ns - granted_ns)
