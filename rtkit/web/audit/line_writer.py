"""Writes lines of a log beside what makes them, which does not wait for whoever reads them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from queue import Full, Queue

from rtkit.link.threads import start_thread

_MOST = 1000
_END_S = 1.0
"""How long the end waits for lines that nobody reads [s]."""


@contextmanager
def written_aside(write: Callable[[str], object]) -> Iterator[Callable[[str], None]]:
    """Yield what has lines written by a thread; those that nobody takes in time are lost.

    How many were lost is told in their place.
    """
    waiting: Queue[str | None] = Queue(_MOST)
    lost = 0

    def put(line: str) -> None:
        nonlocal lost
        try:
            if lost:
                waiting.put_nowait(f"{lost} lines were lost: nobody read them")
                lost = 0
            waiting.put_nowait(line)
        except Full:
            lost += 1

    def run() -> None:
        while (line := waiting.get()) is not None:
            write(line)

    thread = start_thread(run, "log of the page")
    try:
        yield put
    finally:
        try:
            waiting.put(None, timeout=_END_S)
        except Full:
            pass  # the thread goes with the process
        else:
            thread.join(_END_S)
