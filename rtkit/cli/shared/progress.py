"""Shows progress at the foot of a terminal; a pipe or file gets the plain lines only."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

_PERIOD_S = 0.1


class Errors(Protocol):
    """Writes lines on stderr, as `rtkit.cli.shared.app.App` does."""

    write_error: Callable[[str], object]


Show = Callable[[float, float | None, str], None]
"""Is told how much is done, of how much (None when that is open), and a few words."""


class Meter:
    """Shows progress on a terminal, by a line for each of several titles."""

    def __init__(self, app: Errors, titles: Sequence[str]) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        self._console = Console(stderr=True, highlight=False)
        columns = (
            SpinnerColumn(),
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            TextColumn("{task.fields[text]}", markup=False),
            TimeElapsedColumn(),
        )
        self._bar = Progress(*columns, console=self._console, transient=True)
        self._tasks = {each: self._bar.add_task(each, total=None, text="") for each in titles}
        self._due: dict[str, float] = {}
        self._is_hidden = False
        self._app = app

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Have lines of the app go above."""
        from rich.text import Text

        former = self._app.write_error
        self._app.write_error = lambda line: self._console.print(Text(line), soft_wrap=True)
        try:
            yield
        finally:
            self._bar.stop()
            self._app.write_error = former

    def begin(self) -> None:
        """Show the lines from now on."""
        if not self._is_hidden:
            self._bar.start()

    def show(self, title: str, done: float, total: float | None, text: str) -> None:
        """Show how much is done of a title, of how much (None when that is open)."""
        now = time.monotonic()  # thousands a second may come
        if now >= self._due.get(title, 0.0) or done == total:
            self._due[title] = now + _PERIOD_S
            self.begin()
            self._bar.update(self._tasks[title], completed=done, total=total, text=text)

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Leave the terminal to a question to the user while inside."""
        self._is_hidden = True
        self._bar.stop()
        try:
            yield
        finally:
            self._is_hidden = False


@contextmanager
def metered_each(
    app: Errors, titles: Sequence[str], *, is_writing: bool = False
) -> Iterator[Meter | None]:
    """Show progress by a line for each title on stderr while inside; None if it is no terminal.

    A command that `is_writing` its results on a terminal shows its progress by them.
    """
    if not _is_terminal() or (is_writing and sys.stdout.isatty()):
        yield None
        return
    meter = Meter(app, titles)
    with meter.shown():
        yield meter


@contextmanager
def metered(app: Errors, title: str, *, is_writing: bool = False) -> Iterator[Show]:
    """Show progress on stderr while inside, see `metered_each`; lines go above it."""
    with metered_each(app, [title], is_writing=is_writing) as meter:
        if meter is None:
            yield _nothing
            return
        meter.begin()
        yield lambda done, total, text: meter.show(title, done, total, text)


def counted(show: Show) -> Callable[[int, int], None]:
    """Return a function that shows a count out of a total."""
    return lambda done, total: show(done, total, f"{done}/{total}")


@contextmanager
def counting(app: Errors, title: str) -> Iterator[Callable[[int, int], None]]:
    """Show a count out of a total while inside, as `metered` does."""
    with metered(app, title) as show:
        yield counted(show)


def _nothing(_done: float, _total: float | None, _text: str) -> None:
    pass


def _is_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") != "dumb"
