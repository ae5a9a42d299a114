"""Calls between components of one process that cross: A calls B while B, somehow, calls A.

Such a call may wait for a lock that its own caller holds, so that neither comes back. It is
noticed when the circle closes, before it is made; one of any number that meet is the one.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import Any

Run = Callable[[Callable[[], Any], float], Any]
"""Does something on another thread and returns its result, or raises `TimeoutError` in time [s]."""


class Crossings:
    """Who is inside a call of whom, in one process."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._inside: dict[str, dict[str, int]] = {}

    def enter(self, caller: str, provider: str) -> tuple[str, ...]:
        """Note a call that begins; return the circle that it closes, none in most cases.

        A circle begins and ends with the caller.
        """
        with self._lock:
            called = self._inside.setdefault(caller, {})
            called[provider] = called.get(provider, 0) + 1
            if provider in self._inside:
                return self._circle(caller, provider)
            return ()

    def leave(self, caller: str, provider: str) -> None:
        """Note that a call has come back."""
        with self._lock:
            called = self._inside[caller]
            called[provider] -= 1
            if not called[provider]:
                del called[provider]
                if not called:
                    del self._inside[caller]

    def _circle(self, caller: str, provider: str) -> tuple[str, ...]:
        """Return the shortest way on from the provider that comes back to the caller."""
        ways: list[tuple[str, ...]] = [(caller, provider)]
        seen = {provider}
        for way in ways:
            if way[-1] == caller:
                return way
            for each in self._inside.get(way[-1], ()):
                if each not in seen:
                    seen.add(each)
                    ways.append((*way, each))
        return ()
