"""Compares the clock of another host with the one here, as NTP does: by the shortest question."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import NamedTuple

from rtkit.errors import Malformed
from rtkit.rtc.names import LOCAL
from rtkit.tree.client import Tree

QUESTIONS = 9
DRIFT = 2e-4
"""How far two clocks may run apart in a second, 100 ppm each: more than quartz does [s]."""


class ClockOffset(NamedTuple):
    """Offset of another clock.

    Attributes:
        offset_s: How far it is ahead of the one here [s].
        bound_s: By how much that may be wrong at most, when it was found [s].
        round_trip_s: How long the question took [s].
        found_s: When it was found, by the clock here [s since 1970].
    """

    offset_s: float
    bound_s: float
    round_trip_s: float
    found_s: float

    def bound_at(self, moment_s: float) -> float:
        """Return by how much it may be wrong at another moment [s since 1970], for drift [s]."""
        return self.bound_s + DRIFT * abs(moment_s - self.found_s)


class StampClock(NamedTuple):
    """Clock of the host whose components stamp values.

    Attributes:
        host: Its name; empty where that is not known.
        offset_s: How far it was ahead of the one here [s].
        bound_s: By how much that may have been wrong [s].
    """

    host: str = ""
    offset_s: float = 0.0
    bound_s: float = 0.0


def stamp_clock(tree: Tree) -> StampClock:
    """Return the clock that components of a manager stamp values by.

    Raises:
        RtkitError: The manager of another host does not tell the time.
    """
    if tree.place == LOCAL:
        return StampClock(tree.host)
    found = compare(tree)
    return StampClock(tree.host, found.offset_s, found.bound_s)


def estimated(ask: Callable[[], float], questions: int = QUESTIONS) -> ClockOffset:
    """Estimate the offset of a clock that is asked for its time [s since 1970].

    The answer was written at some time between question and answer, whatever the way took in each
    direction: in its middle, give or take half the round trip.

    Raises:
        ValueError: What is answered is no time.
    """
    found = []
    for _ in range(questions):
        began_s, began = time.time(), time.monotonic()
        answer = ask()
        took_s = time.monotonic() - began
        if not math.isfinite(answer):
            raise ValueError(answer)
        offset_s = answer - began_s - took_s / 2
        found.append(ClockOffset(offset_s, took_s / 2, took_s, began_s))
    return min(found, key=lambda each: each.bound_s)


def compare(tree: Tree, questions: int = QUESTIONS) -> ClockOffset:
    """Compare the clock of a manager's host with the one here.

    Raises:
        Unreachable: The manager does not answer in time.
        NotFound: It is of a version that does not tell the time.
        Malformed: What it answers is no time.
    """
    try:
        return estimated(lambda: float(tree.view("clock")), questions)
    except ValueError as error:
        raise Malformed(f"{tree.manager} on {tree.host} does not tell the time: {error}") from error
