"""Listens to one manager: its news, and if wanted its figures, as they come.

What comes is kept in one bounded queue until it is taken; who is too slow loses the oldest, learns
how many those were, and knows all the same what the manager knows now.
"""

from __future__ import annotations

import os
import select
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from time import monotonic
from typing import NamedTuple

from rtkit.closing import Closing
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.figures import FIGURES, Figures, figures_from_text
from rtkit.deployment.happenings import Happening, happenings
from rtkit.deployment.news import (
    TREE,
    News,
    Picture,
    applied,
    news_between,
    news_from_text,
)
from rtkit.errors import Unreachable
from rtkit.tree.bell import Bell
from rtkit.tree.client import Tree

QUEUE = 4096
"""How many news a listener may be behind."""

_HEAR_S = 0.5
_TRIES = 20


class Change(NamedTuple):
    """Something changed.

    Attributes:
        time: When the manager told so [s since 1970].
        lost: How many news were missed before; what they were is found by comparison.
    """

    time: float
    happenings: tuple[Happening, ...]
    lost: int = 0


class Ended(NamedTuple):
    """The manager is no more; nothing comes after that."""

    why: str


Heard = Change | Figures | Ended


class Ear(Closing):
    """An ear at one manager; leave it as a context manager.

    Attributes:
        tree: The connection to it.
        facts: What the manager knows, as of what was taken last.
    """

    def __init__(self, tree: Tree, lines: Iterable[str] = (TREE,)) -> None:
        """Begin to listen.

        Raises:
            Unreachable: The manager does not answer, or what it tells does not arrive.
        """
        self.tree = tree
        self._heard: deque[tuple[str, str]] = deque(maxlen=QUEUE)
        self._bell = Bell()
        self._process: int | None = None
        self._is_over = False
        self._ends: list[Callable[[], object]] = []
        try:
            for line in lines:
                self._ends.append(tree.listen(line, self._take_in(line)))
            picture = self._first_picture()
            self._run, self._number = picture.run, picture.number
            self.facts: Snapshot = picture.facts
            with suppress(ProcessLookupError):
                self._process = os.pidfd_open(self.facts.pid)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Listen no more."""
        while self._ends:
            self._ends.pop()()
        self._bell.close()
        if self._process is not None:
            os.close(self._process)
        self._process = None

    @property
    def sources(self) -> list[int]:
        """Descriptors of which one is readable when there is something to `take`."""
        bell = self._bell.fileno()
        return [bell] if self._process is None else [bell, self._process]

    def wait(self, timeout_s: float | None = None) -> list[Heard]:
        """Wait until something has come, and take it; empty when the time is up."""
        until = None if timeout_s is None else monotonic() + timeout_s
        while not self._is_over:
            left_s = None if until is None else max(0.0, until - monotonic())
            if not select.select(self.sources, [], [], left_s)[0]:
                break
            taken = self.take()
            if taken:
                return taken
        return []

    def take(self) -> list[Heard]:
        """Return what has come, in order; `facts` are then what they are after all of it."""
        self._bell.hush()
        heard: list[Heard] = []
        while self._heard and not self._is_over:
            line, text = self._heard.popleft()
            if line == FIGURES:
                heard.append(figures_from_text(text))
            else:
                heard += self._news(news_from_text(text))
        if not self._is_over and self._is_gone():
            heard.append(self._end("was killed"))
        return heard

    def _news(self, news: News) -> list[Heard]:
        if news.run == self._run and news.number <= self._number:
            return []
        if news.is_last:
            return [self._end("ends")]
        if (news.run, news.number) != (self._run, self._number + 1):
            return self._catch_up(news)
        self._number = news.number
        told = tuple(happenings(self.facts, news))
        self.facts = applied(self.facts, news)
        return [Change(news.time, told)] if told else []

    def _catch_up(self, news: News) -> list[Heard]:
        """Find out by a new picture what the news that were missed meant."""
        lost = max(0, news.number - self._number - 1) if news.run == self._run else 0
        try:
            picture = self.tree.picture()
        except Unreachable as error:
            return [self._end(str(error))]
        missed = news_between(self.facts, picture.facts, picture.run, picture.number)
        told = tuple(happenings(self.facts, missed))
        self._run, self._number, self.facts = picture.run, picture.number, picture.facts
        return [Change(news.time, told, lost)] if told or lost else []

    def _end(self, why: str) -> Ended:
        self._is_over = True
        return Ended(f"manager {self.tree.manager!r} {why}")

    def _is_gone(self) -> bool:
        return self._process is not None and bool(select.select([self._process], [], [], 0)[0])

    def _take_in(self, line: str) -> Callable[[str], object]:
        def take_in(text: str) -> None:
            self._heard.append((line, text))
            self._bell.ring()

        return take_in

    def _first_picture(self) -> Picture:
        """Take a picture, again until news of the manager are seen to arrive."""
        for _ in range(_TRIES):
            picture = self.tree.picture()
            until = monotonic() + _HEAR_S
            while not any(line == TREE for line, _ in self._heard):
                if not select.select([self._bell], [], [], max(0.0, until - monotonic()))[0]:
                    break
                self._bell.hush()
            else:
                self._bell.ring()
                return picture
        raise Unreachable(f"what manager {self.tree.manager!r} tells does not arrive")
