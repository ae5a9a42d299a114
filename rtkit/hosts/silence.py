"""Silence of another host: how long it may last, and what tells that it has lasted too long."""

from __future__ import annotations

import math
import socket
import struct
import threading
from collections.abc import Callable
from time import monotonic

from rtkit.errors import Refused
from rtkit.link.threads import start_thread

_PING_S = 0.5
_SILENT_S, _SILENT_ROUNDS, _LONGEST_ROUND_S = 2.5, 8, 0.5
"""How often the far side is asked whether it is there, and how long it may be silent [s], besides
so many round trips: what a slow network loses comes later than what a quick one does. TCP sends
again after 0.2 to 0.35 s, and each time waits twice as long: what an outage of 1 s has lost comes
up to 2.45 s after it was sent."""
_STALLED_S = 10.0
"""How long answers of a host may stay away whose kernel still acknowledges what is sent [s]: TCP
there sends what was lost five times again after 6.2 s (decision 98)."""
_TCP_INFO = struct.Struct("=52x2I")
"""Milliseconds since data came, and since an acknowledgement did, of ``struct tcp_info``."""


def longest_silence(round_trip_s: float) -> float:
    """Return how long a far side may be silent [s] until it is given up, by a round trip [s]."""
    return _SILENT_S + _SILENT_ROUNDS * min(round_trip_s, _LONGEST_ROUND_S)


def packet_silence(end: object) -> float:
    """Return how long no packet has come from the far side of a socket [s].

    Also those count that bring nothing: acknowledgements, and data behind a packet that was lost.
    It is infinite where `end` is no socket of TCP.
    """
    if not isinstance(end, socket.socket):
        return math.inf
    try:
        info = end.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _TCP_INFO.size)
    except OSError:  # it is closed, or of another family
        return math.inf
    data_ms, acknowledgement_ms = _TCP_INFO.unpack(info)
    return float(min(data_ms, acknowledgement_ms)) / 1000


def await_silence(
    ask: Callable[[], object],
    most_s: float,
    silence_s: Callable[[], float],
    packet_silence_s: Callable[[], float] = lambda: math.inf,
) -> str:
    """Ask again and again whether the far side is there; return why it is not any more.

    Who was heard otherwise meanwhile is there, and may answer late.

    Args:
        ask: Returns when the far side has answered; raises if the connection has ended, `Refused`
            if it is to end for another reason.
        most_s: How long it may be silent [s].
        silence_s: Returns how long nothing else has been heard of it [s].
        packet_silence_s: Returns how long no packet has come from its host [s].
    """
    while True:
        answered, failures, asked_at = threading.Event(), list[Exception](), monotonic()

        def one(answered: threading.Event = answered, failures: list[Exception] = failures) -> None:
            try:
                ask()
            except Exception as error:
                failures.append(error)
            answered.set()

        start_thread(one, "ping")
        left_s = most_s
        while not answered.wait(left_s):
            quiet_s = silence_s()
            unanswered_s = min(quiet_s, monotonic() - asked_at)
            if unanswered_s < _STALLED_S:
                quiet_s = min(quiet_s, packet_silence_s())
            left_s = most_s - quiet_s
            if left_s <= 0:
                return f"no answer in {unanswered_s:.2g} s"
        if failures:
            is_refused = isinstance(failures[0], Refused)
            return str(failures[0]) if is_refused else "the connection has ended"
        threading.Event().wait(_PING_S)
