"""Shows progress at the foot of a terminal; a pipe or file gets the plain lines only."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

_PERIOD_S = 0.1


class Errors(Protocol):
    """Writes lines on stderr, as `rtkit.cli.shared.app.App` does."""

    write_error: Callable[[str], object]


Show = Callable[[float, float | None, str], None]
"""Is told how much is done, of how much (None when that is open), and a few words."""


@contextmanager
def metered(
    app: Errors, title: str, *, is_writing: bool = False, is_asking: bool = False
) -> Iterator[Show]:
    """Show progress on stderr while inside, if that is a terminal; lines go above it.

    A command that `is_writing` its results on a terminal shows its progress by them. One that
    `is_asking` the user something at first has its question alone there until there is progress.
    """
    if not _is_terminal() or (is_writing and sys.stdout.isatty()):
        yield _nothing
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
    from rich.text import Text

    console = Console(stderr=True, highlight=False)
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[text]}"),
        TimeElapsedColumn(),
    )
    bar = Progress(*columns, console=console, transient=True)
    task = bar.add_task(title, total=None, text="")
    former = app.write_error
    app.write_error = lambda line: console.print(Text(line), soft_wrap=True)

    def show(done: float, total: float | None, text: str) -> None:
        bar.start()
        bar.update(task, completed=done, total=total, text=text)

    try:
        if not is_asking:
            bar.start()
        yield _paced(show)
    finally:
        bar.stop()
        app.write_error = former


def counted(show: Show) -> Callable[[int, int], None]:
    """Return a function that shows a count out of a total."""
    return lambda done, total: show(done, total, f"{done}/{total}")


@contextmanager
def counting(app: Errors, title: str) -> Iterator[Callable[[int, int], None]]:
    """Show a count out of a total while inside, as `metered` does."""
    with metered(app, title) as show:
        yield counted(show)


def _paced(show: Show) -> Show:
    """Return a function that shows progress at a readable rate: thousands a second may come."""
    due = 0.0

    def paced(done: float, total: float | None, text: str) -> None:
        nonlocal due
        now = time.monotonic()
        if now >= due or done == total:
            due = now + _PERIOD_S
            show(done, total, text)

    return paced


def _nothing(_done: float, _total: float | None, _text: str) -> None:
    pass


def _is_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") != "dumb"
