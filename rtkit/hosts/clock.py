"""Compares the clock of another host with the one here, as NTP does: by the shortest question."""

from __future__ import annotations

import math
import time
from typing import NamedTuple

from rtkit.errors import Refused, Unreachable
from rtkit.hosts.connection import HostConnection
from rtkit.hosts.far_program import MARK, answer_in

_QUESTIONS, _LONGEST = 9, 1 << 16
_PROGRAM = (
    "import sys, time\n"
    "while sys.stdin.buffer.read(1):\n"
    " sys.stdout.write(sys.argv[1] + repr(time.time()) + chr(10)); sys.stdout.flush()\n"
)


class ClockOffset(NamedTuple):
    """Offset of another clock.

    Attributes:
        offset_s: How far it is ahead of the one here [s].
        bound_s: By how much that may be wrong at most [s].
        round_trip_s: How long the question took [s].
    """

    offset_s: float
    bound_s: float
    round_trip_s: float


def compare(connection: HostConnection, timeout_s: float = 5.0) -> ClockOffset:
    """Compare the clocks.

    The answer was written at some time between question and answer, whatever the way took in each
    direction: in its middle, give or take half the round trip.

    Raises:
        Refused: Python there does not answer so.
        Unreachable: The connection ended, or nothing came in time.
    """
    host = connection.host
    channel = connection.open([host.python, "-u", "-c", _PROGRAM, MARK])
    until = time.monotonic() + timeout_s
    found = []
    try:
        for _ in range(_QUESTIONS):
            began_s, began = time.time(), time.monotonic()
            channel.sendall(b"?")
            text = b""
            while (answer := answer_in(text)) is None:
                channel.settimeout(max(0.001, until - time.monotonic()))
                data = channel.recv(1 << 12)
                if not data or len(text) > _LONGEST:
                    raise Refused(f"{host.name}: {host.python} does not tell the time")
                text += data
            took_s = time.monotonic() - began
            if not math.isfinite(float(answer)):
                raise ValueError(answer)
            found.append(ClockOffset(float(answer) - began_s - took_s / 2, took_s / 2, took_s))
    except ValueError as error:
        raise Refused(f"{host.name}: {host.python} does not tell the time: {error}") from error
    except OSError as error:
        raise Unreachable(f"{host.name}: no answer about its clock: {error}") from error
    finally:
        channel.close()
    return min(found, key=lambda each: each.bound_s)
