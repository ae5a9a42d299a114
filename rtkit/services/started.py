"""Process of a service that was started: ended with all that it started, its last words known."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Sequence
from contextlib import suppress
from typing import Final

from rtkit.services.left import marked

_ENDING_S = 5.0
_LONGEST = 4096
"""Bytes of a line of error output that are kept."""


class StartedProcess:
    """Process in a group of its own; what it writes as errors goes where ours go.

    Args:
        kind: Of service.
        command: Program and arguments.
        socket: Of the service that starts it, whose successor finds it by that.

    Attributes:
        kind: Of service.
        last: The last line that it has written as an error.

    Raises:
        OSError: It cannot be started.
    """

    def __init__(self, kind: str, command: Sequence[str], socket: str = "") -> None:
        self.kind: Final = kind
        self.last = ""
        self._is_stopped = False
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            env=marked(socket, kind),
            start_new_session=True,
        )
        self._reading = threading.Thread(target=self._read, name="errors", daemon=True)
        self._reading.start()

    def _read(self) -> None:
        assert self._process.stderr is not None
        with self._process.stderr as errors:
            while line := errors.readline(_LONGEST):
                self.last = line.decode("utf-8", "replace").strip() or self.last
                with suppress(OSError):  # nobody reads ours: it is to go on all the same
                    os.write(2, line)

    @property
    def is_running(self) -> bool:
        """Tells that it has not ended yet."""
        return self._process.poll() is None

    @property
    def outcome(self) -> str:
        """Its status at the end, and its last error; once it has ended."""
        self._reading.join(_ENDING_S)
        return f"{self._process.wait()}{f': {self.last}' if self.last else ''}"

    def stop(self, number: int = signal.SIGTERM) -> None:
        """Send a signal to it and to all that it started, unless it has ended."""
        self._is_stopped = True
        if self.is_running:
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, number)

    def end(self) -> None:
        """Stop it, by force if it takes long, and wait until it has ended."""
        if not self._is_stopped:  # a second signal may find its handler at work
            self.stop()
        self._reading.join(_ENDING_S)  # what it started has its error output, too
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_ENDING_S)
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
