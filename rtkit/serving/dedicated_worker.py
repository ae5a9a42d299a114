"""Dedicated workers: threads for the few clients that ask one thing after another.

A thread that waits at one socket wakes sooner, and has less to do, than a loop that watches all:
a request costs not twice, but half as much again as a bare echo. A dedicated worker answers
only requests that need no wait, by the same rules and with the lock of the host; for anything else
(another request, a reply that is not read, a pause) the client goes back to the loop.

See decision 34.
"""

from __future__ import annotations

import contextlib
import socket
import struct
import threading
from collections.abc import Callable
from typing import NamedTuple

MOST = 8
"""Dedicated workers of one host."""
PAUSE_S = 0.25
"""How long one waits for the next request [s]."""
_FEW = 1 << 12
_PAUSE = struct.pack("@ll", int(PAUSE_S), int(PAUSE_S % 1 * 1e6))


class WorkerExit(NamedTuple):
    """Reason for which a dedicated worker leaves a client.

    Attributes:
        data: Bytes received and not answered; empty if the client has hung up, None at a pause.
        unsent: The rest of a reply that was not read.
    """

    data: bytes | None
    unsent: bytes = b""


class DedicatedWorkers:
    """All dedicated workers of one host.

    Args:
        lock: Of the host.
    """

    def __init__(self, lock: threading.Lock) -> None:
        self._lock = lock
        self._ends: dict[socket.socket, threading.Thread] = {}

    def begin(
        self,
        end: socket.socket,
        answer: Callable[[bytes], bytes | None],
        back: Callable[[WorkerExit], object],
    ) -> bool:
        """Attend to a client, at whose socket nobody else waits; return whether one is free.

        Args:
            end: Its socket.
            answer: Returns the reply to what came, None if it takes more than a look; it is called
                with the lock.
            back: Takes the client back; on the thread of the dedicated worker.
        """
        if len(self._ends) >= MOST:
            return False

        def run() -> None:
            left = self._attend(end, answer)
            del self._ends[end]
            back(left)

        end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, _PAUSE)
        end.setblocking(True)
        self._ends[end] = threading.Thread(target=run, name="attendant", daemon=True)
        self._ends[end].start()
        return True

    def _attend(self, end: socket.socket, answer: Callable[[bytes], bytes | None]) -> WorkerExit:
        receive, send, lock = end.recv, end.send, self._lock
        at_once = socket.MSG_DONTWAIT
        while True:
            try:
                data = receive(_FEW)
            except BlockingIOError:
                return WorkerExit(None)
            except OSError:
                return WorkerExit(b"")
            with lock:
                reply = answer(data)
            if reply is None:
                return WorkerExit(data)
            try:
                sent = send(reply, at_once)
            except OSError:  # it has gone, which the loop will notice, or it does not read
                sent = 0
            if sent < len(reply):
                return WorkerExit(None, reply[sent:])

    def close(self) -> None:
        """Hang up on those who are attended to, and wait until nobody is."""
        for end, thread in list(self._ends.items()):
            with contextlib.suppress(OSError):  # it has hung up itself
                end.shutdown(socket.SHUT_RDWR)
            thread.join()
