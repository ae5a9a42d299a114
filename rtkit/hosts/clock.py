"""Compares the clock of another host with the one here over SSH, also where no manager runs."""

from __future__ import annotations

import time

from rtkit.errors import Refused, Unreachable
from rtkit.hosts.connection import HostConnection
from rtkit.hosts.far_program import MARK, answer_in
from rtkit.tree.clock import ClockOffset, estimated

_LONGEST = 1 << 16
_PROGRAM = (
    "import sys, time\n"
    "while sys.stdin.buffer.read(1):\n"
    " sys.stdout.write(sys.argv[1] + repr(time.time()) + chr(10)); sys.stdout.flush()\n"
)


def compare(connection: HostConnection, timeout_s: float = 5.0) -> ClockOffset:
    """Compare the clocks.

    Raises:
        Refused: Python there does not answer so.
        Unreachable: The connection ended, or nothing came in time.
    """
    host = connection.host
    channel = connection.open([host.python, "-u", "-c", _PROGRAM, MARK])
    until = time.monotonic() + timeout_s

    def ask() -> float:
        channel.sendall(b"?")
        text = b""
        while (answer := answer_in(text)) is None:
            channel.settimeout(max(0.001, until - time.monotonic()))
            data = channel.recv(1 << 12)
            if not data or len(text) > _LONGEST:
                raise Refused(f"{host.name}: {host.python} does not tell the time")
            text += data
        return float(answer)

    try:
        return estimated(ask)
    except ValueError as error:
        raise Refused(f"{host.name}: {host.python} does not tell the time: {error}") from error
    except OSError as error:
        raise Unreachable(f"{host.name}: no answer about its clock: {error}") from error
    finally:
        channel.close()
