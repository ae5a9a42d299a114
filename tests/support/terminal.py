"""Runs a program in a real terminal: types keys and reads the screen."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import signal
import struct
import termios
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

_PATIENCE_S = 30.0


class Terminal:
    """The other end of a pseudo-terminal.

    Attributes:
        pid: The program in it.
        seen: What it wrote since the last `until`.
    """

    def __init__(self, pid: int, fd: int) -> None:
        self.pid = pid
        self._fd = fd
        self.seen = ""

    def type(self, text: str) -> None:
        """Type keys, all at once: what the program is not ready for waits in the terminal."""
        data = text.encode()
        while data:
            data = data[os.write(self._fd, data) :]

    def until(self, pattern: str) -> re.Match[str]:
        """Wait until something is seen, and return it; what came up to there is forgotten."""
        deadline = time.monotonic() + _PATIENCE_S
        while not (match := re.search(pattern, self.seen)):
            left = deadline - time.monotonic()
            is_there = left > 0 and select.select([self._fd], [], [], left)[0]
            text = self._read() if is_there else ""
            assert text, f"{pattern!r} was never seen, but {self.seen!r}"
            self.seen += text
        self.seen = self.seen[match.end() :]
        return match

    def more(self, patience_s: float = _PATIENCE_S) -> str:
        """Wait for whatever comes next and return it; empty when nothing does, or at the end."""
        if not select.select([self._fd], [], [], patience_s)[0]:
            return ""
        text = self._read()
        self.seen += text
        return text

    def rest(self) -> str:
        """Return what is seen until the program ends."""
        while text := self._read():
            self.seen += text
        return self.seen

    def modes(self) -> list[object]:
        """Return how it treats what is typed, as termios has it."""
        return termios.tcgetattr(self._fd)

    def resize(self, columns: int, rows: int = 24) -> None:
        """Give the terminal another size; its program is told."""
        fcntl.ioctl(self._fd, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def status(self) -> int:
        """Wait for the end of the program and return its exit status, negative for a signal."""
        self.rest()
        return os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])

    def _read(self) -> str:
        try:
            return os.read(self._fd, 65536).decode(errors="replace")
        except OSError:
            return ""  # nobody has the other end any more


@contextmanager
def opened(
    argv: Sequence[str], environment: Mapping[str, str], folder: Path, columns: int = 80
) -> Iterator[Terminal]:
    """Run a program in a terminal of its own, which ends with the block."""
    pid, fd = pty.fork()
    if pid == 0:
        try:
            os.chdir(folder)
            fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
            os.execvpe(argv[0], list(argv), dict(environment))
        finally:
            os._exit(127)
    try:
        yield Terminal(pid, fd)
    finally:
        os.close(fd)
        try:
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)
        except (ProcessLookupError, ChildProcessError):
            pass  # it has ended
