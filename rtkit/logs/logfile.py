"""Log targets: a file that is kept short, or a terminal; neither ever blocks the logger.

Records that cannot be written are dropped and counted; the first one that can be written again
follows one with the number of those missing.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import logging
import os
import select
import stat
from typing import Protocol

MAX_BYTES = 1024 * 1024
"""Where a log file ends and the next one begins."""

FILES = 3
"""How many files there are of a log: the present one, then ``.1`` and ``.2``, which are older."""

_FLAGS = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK
_CHUNK = select.PIPE_BUF


class LogTarget(Protocol):
    """Accepts text, or reports that it cannot."""

    def write(self, text: bytes) -> None:
        """Write it all, at once, or raise OSError."""

    def close(self) -> None:
        """Let go of what it holds."""


class Lossy(logging.Handler):
    """Writes records to a target; drops and counts those that it does not take."""

    def __init__(self, target: LogTarget, formatter: logging.Formatter) -> None:
        super().__init__()
        self.setFormatter(formatter)
        self._target = target
        self._dropped = 0
        self._why = ""

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record, or count it; nothing is raised at who logs."""
        try:
            text = self.format(record)
            if self._dropped:
                text = f"{self.format(self._loss(record))}\n{text}"
            self._target.write(f"{text}\n".encode("utf-8", "backslashreplace"))
        except Exception as error:
            self._dropped += 1
            self._why = getattr(error, "strerror", None) or f"{type(error).__name__}: {error}"
        else:
            self._dropped = 0

    def close(self) -> None:
        """Let go of the target."""
        self._target.close()
        super().close()

    def _loss(self, record: logging.LogRecord) -> logging.LogRecord:
        text = f"{self._dropped} log records were lost: {self._why}"
        loss = logging.LogRecord(__name__, logging.WARNING, __file__, 0, text, (), None)
        loss.created, loss.msecs = record.created, record.msecs
        return loss


class LogFile:
    """A file of lines that is begun anew when it is full; the older ones are kept beside it.

    Several processes may write to the same one: each line is one write to its end, and who finds
    that another one has begun the file anew follows.
    """

    def __init__(self, path: str, max_bytes: int = MAX_BYTES, files: int = FILES) -> None:
        self.path = path
        self._max_bytes = max_bytes
        self._files = files
        self._descriptor = -1
        self._identity = (0, 0)
        self._is_torn = False

    def write(self, text: bytes) -> None:
        """Append a line.

        Raises:
            OSError: There is no room, or the file cannot be written.
        """
        size = self._follow()
        if size and size + len(text) > self._max_bytes:
            self._turn_over()
            self._follow()
        whole = b"\n" + text if self._is_torn else text
        written = os.write(self._descriptor, whole)
        self._is_torn = written < len(whole)
        if self._is_torn:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def move(self, path: str) -> None:
        """Write to another file from now on."""
        self.close()
        self.path = path

    def close(self) -> None:
        """Close the file; a line that is written later opens it again."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def _follow(self) -> int:
        """Have the file open that lies at the path now; return its size."""
        try:
            status = os.stat(self.path, follow_symlinks=False)
        except FileNotFoundError:
            status = None
        if status is None or self._descriptor < 0 or _identity(status) != self._identity:
            self.close()
            self._descriptor = open_private(self.path)
            status = os.fstat(self._descriptor)
            self._identity = _identity(status)
            self._is_torn = False
        return status.st_size

    def _turn_over(self) -> None:
        """Move each file one on, unless another process does so at this moment."""
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return
        if _identity(os.stat(self.path, follow_symlinks=False)) != self._identity:
            return
        for number in range(self._files - 1, 0, -1):
            older = f"{self.path}.{number}"
            newer = f"{self.path}.{number - 1}" if number > 1 else self.path
            with contextlib.suppress(FileNotFoundError):
                os.replace(newer, older)
        self.close()  # which frees the lock too


class Terminal:
    """A terminal, or a pipe to whatever shows text; one that is held up does not hold us up."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._poll = select.poll()
        self._poll.register(descriptor, select.POLLOUT)

    def write(self, text: bytes) -> None:
        """Write lines.

        Raises:
            OSError: It is held up, or gone.
        """
        for start in range(0, len(text), _CHUNK):
            if not self._poll.poll(0):
                raise OSError(errno.EAGAIN, "the terminal was held up")
            os.write(self._descriptor, text[start : start + _CHUNK])

    def close(self) -> None:
        """Close the descriptor."""
        os.close(self._descriptor)


def open_private(path: str) -> int:
    """Open a file for lines at its end, for this user alone, and return the descriptor.

    Raises:
        OSError: It cannot be opened, or is no file.
    """
    descriptor = os.open(path, _FLAGS, 0o600)
    try:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "not a file")
        if stat.S_IMODE(status.st_mode) != 0o600:
            os.fchmod(descriptor, 0o600)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def _identity(status: os.stat_result) -> tuple[int, int]:
    return status.st_dev, status.st_ino
