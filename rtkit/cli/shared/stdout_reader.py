"""Watches the reader of stdout: a waiting command ends when its reader has gone."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class StdoutReader:
    """State of the reader of stdout.

    Attributes:
        is_gone: Whether the reader has left.
    """

    is_gone = False

    def check(self) -> None:
        """Fail as a write would.

        Raises:
            BrokenPipeError: Nobody reads any more.
        """
        if self.is_gone:
            raise BrokenPipeError


@contextmanager
def while_read(gone: Callable[[], object]) -> Iterator[StdoutReader]:
    """Call `gone`, on a thread of its own, once nobody reads stdout, though nothing is written.

    So a command that waits for what is to come ends with the reader of its pipe.
    """
    import select
    import threading

    reader = StdoutReader()
    descriptor = _pipe()
    if descriptor is None:
        yield reader
        return
    ending, end = os.pipe()
    poll = select.poll()
    poll.register(descriptor, 0)
    poll.register(ending, select.POLLIN)

    def watch() -> None:
        if any(each == descriptor for each, _ in poll.poll()):
            reader.is_gone = True
            gone()

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield reader
    finally:
        os.close(end)
        thread.join()
        os.close(ending)


def _pipe() -> int | None:
    """Return the descriptor of stdout if it is a pipe or a socket, which a reader can leave."""
    try:
        descriptor = sys.stdout.fileno()
        mode = os.fstat(descriptor).st_mode
    except (OSError, ValueError, AttributeError):
        return None
    return descriptor if stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode) else None
