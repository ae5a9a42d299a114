"""Detects calls that cross between components of one process: A calls B while B calls A.

Such a call may wait for a lock that its own caller holds, so that neither returns. The circle is
detected before the call that closes it is made.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Run = Callable[[Callable[[], Any], float], Any]
"""Does something on another thread and returns its result, or raises `TimeoutError` in time [s]."""


class Reentrancy:
    """The calls under way between components of one process; used by any number of threads.

    There is no lock: each call is noted before the search for circles, so that among concurrent
    calls the one noted last finds all others.
    """

    def __init__(self) -> None:
        self._calls: dict[object, tuple[str, str]] = {}

    def enter(self, caller: str, provider: str) -> tuple[object, tuple[str, ...]]:
        """Note a call that begins.

        Returns:
            Its token (see `leave`), and the circle that it closes, from the caller to the caller;
            none in most cases.
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
