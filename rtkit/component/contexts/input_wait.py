"""Waits of components for input: since when each waits, and which are to end theirs.

A callback that waits for a line cannot be cancelled from outside, so a component that is to be
deactivated or ended has its wait raise `InputEnded`.

See decision 94.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

WAITS = "waiting for input"
_AGAIN_S = 0.1
"""Time between two refusals [s]."""


class InputEnded(SystemExit):
    """Raised where a component waits for input when it is to be deactivated or ended.

    No failure of its callback: that is left, and counts as done. Code that handles errors lets it
    pass, as it does `SystemExit`.
    """


class EndOfWaits(Protocol):
    """Ends the waits of a component when it is rung, until it is hushed."""

    def ring(self) -> object:
        """Have each wait end."""

    def hush(self) -> object:
        """Let it wait again."""


class _Refusals:
    """Count of the times that input was refused to a component since it is to leave."""

    def __init__(self) -> None:
        self.count = 0


_since: dict[str, float] = {}
_leaving: dict[str, _Refusals] = {}
_wakers: dict[str, EndOfWaits] = {}
_waits: dict[str, tuple[EndOfWaits, ...]] = {}
"""Waits for something else than input that are under way."""


def begin_wait(instance: str) -> None:
    """Note that a component waits for input."""
    _since[instance] = time.time()


def end_wait(instance: str) -> None:
    """Note that a component waits for input no longer."""
    _since.pop(instance, None)


def wait_of(instance: str) -> str:
    """Return ``waiting for input since 12:00:00`` of a component that does; else nothing."""
    since = _since.get(instance)
    if since is None:
        return ""
    return f"{WAITS} since {time.strftime('%H:%M:%S', time.localtime(since))}"


def ended_by(instance: str, end: EndOfWaits | None) -> None:
    """Register what ends the waits of a component; None: remove it."""
    if end is None:
        _wakers.pop(instance, None)
    else:
        _wakers[instance] = end


def leave_input(instance: str) -> None:
    """Have each wait of a component end, those that begin from now on too."""
    _leaving.setdefault(instance, _Refusals())
    end = _wakers.get(instance)
    if end is not None:
        end.ring()
    for each in _waits.get(instance, ()):
        each.ring()


def is_leaving(instance: str) -> bool:
    """Return whether each wait of a component is to end."""
    return instance in _leaving


@contextmanager
def ended_with_input(instance: str, end: EndOfWaits) -> Iterator[None]:
    """Have a wait for something else than input end, too, while this is entered."""
    _waits[instance] = (*_waits.get(instance, ()), end)
    try:
        yield
    finally:
        _waits[instance] = tuple(each for each in _waits[instance] if each is not end)


def allow_input(instance: str) -> None:
    """Let a component wait again."""
    _leaving.pop(instance, None)
    end = _wakers.get(instance)
    if end is not None:
        end.hush()


def check_input(instance: str) -> None:
    """Raise if a component is to wait for no more input.

    Raises:
        InputEnded: It is to be deactivated or ended.
    """
    refusals = _leaving.get(instance)
    if refusals is not None:
        refusals.count += 1
        if refusals.count > 1:
            # A loop that catches everything asks again and again: it is not to fill a processor.
            time.sleep(_AGAIN_S)
        raise InputEnded(f"{instance} is to wait for no more input")
