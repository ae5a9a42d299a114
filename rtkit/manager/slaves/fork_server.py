"""Starts the zygote by exec, restarts it with back-off, and keeps its socket."""

from __future__ import annotations

import json
import logging
import os
import signal
import socket
import sys
import time
from collections.abc import Mapping
from typing import Any

from rtkit.container.control_channel import ControlChannel
from rtkit.deployment.message import Message
from rtkit.errors import Malformed
from rtkit.link.processes import ProcessWatch
from rtkit.manager.child_process import Backoff, exit_reason, unmarked, withhold

_log = logging.getLogger(__name__)
_ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
_DYING_S = 0.1
"""How long a process whose connection ended may take to be a zombie [s]."""


class ForkServer:
    """Runs one zygote after the other.

    Attributes:
        channel: To the present one; it ends, with its children, when that is closed.
        backoff: Of the starts; proven when a slave has connected.
        pid: Of the present one, or of the last.
        ends: How those ended that were reaped elsewhere, by pid.
        start_at: When the next one is due, monotonic [s]; None while there is one.
    """

    def __init__(self, settings: Mapping[str, Any]) -> None:
        self._settings = json.dumps(settings)
        self.backoff = Backoff()
        self.channel: ControlChannel
        self.pid = 0
        self.ends: dict[int, str] = {}
        self.start_at: float | None = None
        self.start()

    def start(self) -> None:
        """Start one."""
        ours, theirs = socket.socketpair()
        with theirs:
            withhold()
            theirs.set_inheritable(True)
            module = ["-P", "-m", "rtkit.manager.slaves.zygote"]
            arguments = [sys.executable, *module, str(theirs.fileno()), self._settings]
            environment = {**unmarked(os.environ), **_ONE_THREAD}  # it outlives the manager
            # Decision 49: not by fork, which a session of zenoh in this process does not survive.
            self.pid = os.posix_spawn(sys.executable, arguments, environment)
        ours.setblocking(False)
        self.channel = ControlChannel(ours)
        self.backoff.begin(time.monotonic())
        self.start_at = None

    def receive(self) -> list[Message] | None:
        """Return what it reports; None when it ended, or cannot be understood."""
        if self.start_at is not None:
            return None
        try:
            messages = self.channel.receive()
            self.channel.flush()
        except (Malformed, OSError) as error:
            _log.error("the line to the zygote is broken: %s", error)
            return None
        return messages

    @property
    def is_failing(self) -> bool:
        """Return whether the zygotes that were started lately did not live long."""
        return self.backoff.failures > 1

    def release(self) -> str:
        """Close the connection to one that ended, schedule the next; return what happened."""
        self.channel.close()
        why = f"the zygote ended: {self._end()}"
        wait_s = self.backoff.end(time.monotonic())
        self.start_at = time.monotonic() + wait_s
        if self.is_failing:
            moment = time.strftime("%H:%M:%S", time.localtime(time.time() + wait_s))
            why += f", {self.backoff.failures} times in succession; started again at {moment}"
        return why

    def _end(self) -> str:
        """Return how it ended; one that only gave up its connection is killed."""
        if self.pid in self.ends:
            return self.ends.pop(self.pid)
        with ProcessWatch(self.pid) as process:
            is_over = process.await_end(_DYING_S)
            if not is_over:
                process.send(signal.SIGKILL)
        report = os.waitid(os.P_PID, self.pid, os.WEXITED)
        how = exit_reason(report) if report is not None else "exit status unknown"
        return how if is_over else "its line broke, and it was killed"
