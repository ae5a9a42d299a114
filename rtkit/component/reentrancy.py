"""Calls between components of one process that cross: A calls B while B, somehow, calls A.

Such a call may wait for a lock that its own caller holds, so that neither comes back. It is
noticed when the circle closes, before it is made.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Run = Callable[[Callable[[], Any], float], Any]
"""Does something on another thread and returns its result, or raises `TimeoutError` in time [s]."""


class Reentrancy:
    """Who is inside a call of whom, in one process; used by any number of threads.

    There is no lock: a call is noted before it is looked for circles, so that of calls that meet
    the last one to be noted finds all others.
    """

    def __init__(self) -> None:
        self._calls: dict[object, tuple[str, str]] = {}

    def enter(self, caller: str, provider: str) -> tuple[object, tuple[str, ...]]:
        """Note a call that begins.

        Returns:
            What ends it (see `leave`), and the circle that it closes, from the caller to the
            caller; none in most cases.
        """
        call = object()
        self._calls[call] = (caller, provider)
        if len(self._calls) == 1 and caller != provider:
            return call, ()
        return call, self._circle(caller, provider)

    def leave(self, call: object) -> None:
        """Note that a call has come back."""
        del self._calls[call]

    def _circle(self, caller: str, provider: str) -> tuple[str, ...]:
        """Return the shortest way on from the provider that comes back to the caller."""
        steps = set(self._calls.copy().values())
        ways: list[tuple[str, ...]] = [(caller, provider)]
        seen = {provider}
        for way in ways:
            if way[-1] == caller:
                return way
            ahead = {to for start, to in steps if start == way[-1]} - seen
            seen |= ahead
            ways += [(*way, each) for each in sorted(ahead)]
        return ()
