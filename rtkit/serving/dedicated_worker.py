"""Dedicated workers: threads for the few clients that ask one thing after another.

A thread that waits at one socket, answers and sends is what a bare server is: nothing is handed
over. A loop that watches all sockets has more to do for each request, and code of users would run
on a third thread. A dedicated worker answers by the same rules and with the lock of the host. What
takes more than a line (several requests at once, an id, listening, a reply that is not read), what
takes its time, and a long pause lead the client back to the loop.

See decision 92.
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
PAUSE_S = 5.0
"""How long one waits for the next request [s]."""
_FEW = 1 << 12
_CLOSING_S = 1.0


class WorkerExit(NamedTuple):
    """Reason for which a dedicated worker leaves a client.

    Attributes:
        has_gone: The client has hung up.
        unsent: The rest of a reply that was not read.
    """

    has_gone: bool = False
    unsent: bytes = b""


class DedicatedWorker:
    """Thread that serves one client.

    Args:
        end: Its socket, at which nobody else waits.
        answer: Returns what is to be sent for what came, None to leave the client, and always once
            it is dismissed; it is called with the lock.
        back: Takes the client back; with the lock.
    """

    def __init__(
        self,
        end: socket.socket,
        answer: Callable[[bytes], bytes | None],
        back: Callable[[WorkerExit], object],
    ) -> None:
        self._end = end
        self._answer = answer
        self._back = back
        self._is_dismissed = False

    def attend(self, lock: threading.Lock, data: bytes) -> None:
        """Answer what came, and what comes next, until the client is to be left."""
        receive, send, answer = self._end.recv, self._end.send, self._answer
        at_once = socket.MSG_DONTWAIT
        while True:
            with lock:
                reply = answer(data)
            if reply is None:
                left = WorkerExit()
                break
            try:
                sent = send(reply, at_once)
            except OSError:  # it has gone, which the loop will notice, or it does not read
                sent = 0
            if sent < len(reply):
                left = WorkerExit(unsent=reply[sent:])
                break
            try:
                data = receive(_FEW)
            except BlockingIOError:
                left = WorkerExit()
                break
            except OSError:
                data = b""
            if not data:
                left = WorkerExit(has_gone=True)
                break
        with lock:
            if not self._is_dismissed:
                self._back(left)

    def dismiss(self) -> None:
        """Note, with the lock, that the loop has the client back, whose request is answered."""
        self._is_dismissed = True

    def hang_up(self) -> None:
        """Hang up on the client."""
        with contextlib.suppress(OSError):  # it has hung up itself
            self._end.shutdown(socket.SHUT_RDWR)


class DedicatedWorkers:
    """All dedicated workers of one host.

    Args:
        lock: Of the host.
    """

    def __init__(self, lock: threading.Lock) -> None:
        self._lock = lock
        self._threads: dict[DedicatedWorker, threading.Thread] = {}

    @property
    def is_any_free(self) -> bool:
        """Return whether there may be one more."""
        return len(self._threads) < MOST

    def begin(self, worker: DedicatedWorker, end: socket.socket, run: Callable[[], object]) -> None:
        """Have a worker attend to its client; `run` is called by its thread."""

        def work() -> None:
            try:
                run()
            finally:
                del self._threads[worker]

        pause = struct.pack("@ll", int(PAUSE_S), int(PAUSE_S % 1 * 1e6))
        end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, pause)
        end.setblocking(True)
        thread = threading.Thread(target=work, name="attendant", daemon=True)
        self._threads[worker] = thread
        thread.start()

    def close(self) -> None:
        """Hang up on those who are attended to; wait until nobody is, but not for user code."""
        for worker, thread in list(self._threads.items()):
            worker.hang_up()
            thread.join(_CLOSING_S)
