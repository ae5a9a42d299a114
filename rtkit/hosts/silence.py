"""Silence of another host: how long it may last, and what tells that it has lasted too long."""

from __future__ import annotations

import threading
from collections.abc import Callable

from rtkit.errors import Refused
from rtkit.link.threads import start_thread

_PING_S = 0.5
_SILENT_S, _SILENT_ROUNDS, _LONGEST_ROUND_S = 2.5, 8, 0.5
"""How often the far side is asked whether it is there, and how long it may be silent [s], besides
so many round trips: what a slow network loses comes later than what a quick one does. TCP sends
again after 0.2 to 0.35 s, and each time waits twice as long: what an outage of 1 s has lost comes
up to 2.45 s after it was sent."""


def longest_silence(round_trip_s: float) -> float:
    """Return how long a far side may be silent [s] until it is given up, by a round trip [s]."""
    return _SILENT_S + _SILENT_ROUNDS * min(round_trip_s, _LONGEST_ROUND_S)


def await_silence(ask: Callable[[], object], most_s: float, silence_s: Callable[[], float]) -> str:
    """Ask again and again whether the far side is there; return why it is not any more.

    Who was heard otherwise meanwhile is there, and may answer late.

    Args:
        ask: Returns when the far side has answered; raises if the connection has ended, `Refused`
            if it is to end for another reason.
        most_s: How long it may be silent [s].
        silence_s: Returns how long nothing else has been heard of it [s].
    """
    while True:
        answered, failures = threading.Event(), list[Exception]()

        def one(answered: threading.Event = answered, failures: list[Exception] = failures) -> None:
            try:
                ask()
            except Exception as error:
                failures.append(error)
            answered.set()

        start_thread(one, "ping")
        while not answered.wait(most_s):
            if silence_s() > most_s:
                return f"no answer in {most_s:.2g} s"
        if failures:
            is_refused = isinstance(failures[0], Refused)
            return str(failures[0]) if is_refused else "the connection has ended"
        threading.Event().wait(_PING_S)
