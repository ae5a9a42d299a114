"""Child process that a manager keeps as long as it is wanted: another one follows each end."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence

from rtkit.link.processes import ProcessWatch
from rtkit.manager.child_process import Backoff, exit_reason

_END_S = 2.0


class KeptProcess:
    """A process of a module, begun at once, and again whenever it has ended.

    Args:
        arguments: The module, and what it is given.
        ended: Receives how it ended, unless that was asked for.
        closed: Called once it is to be there no more.
    """

    def __init__(
        self,
        arguments: Sequence[str],
        ended: Callable[[str], object],
        closed: Callable[[], object] = lambda: None,
    ) -> None:
        self._arguments = [sys.executable, "-P", "-m", *arguments]
        self._ended, self._closed = ended, closed
        self._closing = threading.Event()
        self._watch: ProcessWatch | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        backoff = Backoff()
        while not self._closing.is_set():
            backoff.begin(time.monotonic())
            pid = os.posix_spawn(sys.executable, self._arguments, os.environ)
            self._watch = ProcessWatch(pid)
            if self._closing.is_set():
                self._watch.send(signal.SIGKILL)
            how = _reap(pid)
            if not self._closing.is_set():
                self._ended(how)
                self._closing.wait(backoff.end(time.monotonic()))
        self._closed()

    def hasten(self) -> None:
        """Have it look at once, if it waits."""
        if self._watch is not None:
            self._watch.send(signal.SIGCONT)

    def close(self) -> None:
        """End it."""
        self._closing.set()
        if self._watch is not None:
            self._watch.send(signal.SIGKILL)
        self._thread.join(_END_S)


def _reap(pid: int) -> str:
    try:
        report = os.waitid(os.P_PID, pid, os.WEXITED)
    except ChildProcessError:  # another thread has waited for all children
        report = None
    return exit_reason(report) if report is not None else "exit status unknown"
