"""Watches the reader of stdout: whatever a command waits for, it ends when its reader has gone."""

from __future__ import annotations

import os
import select
import stat
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from time import monotonic


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


_GONE = select.POLLERR | select.POLLHUP | select.POLLNVAL


def wait_for(sources: Iterable[int], until: float | None, *, needs_reader: bool = True) -> set[int]:
    """Wait until descriptors are readable and return those; none when the time is up.

    Args:
        sources: Descriptors to wait for.
        until: Deadline, monotonic [s]; None for none.
        needs_reader: Whether stdout is watched.

    Raises:
        BrokenPipeError: Nobody reads stdout any more.
    """
    poll = select.poll()
    out = _stdout() if needs_reader else None
    if out is not None:
        poll.register(out, 0)
    for each in sources:
        poll.register(each, select.POLLIN)
    wait_ms = None if until is None else max(0.0, until - monotonic()) * 1000
    ready = dict(poll.poll(wait_ms))
    if out is not None and ready.pop(out, 0) & _GONE:
        raise BrokenPipeError
    return set(ready)


def _stdout() -> int | None:
    try:
        return sys.stdout.fileno()
    except (OSError, ValueError):
        return None
