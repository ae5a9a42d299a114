"""Sessions: runs of operations on a system, of a command or, as here, of a script."""

from __future__ import annotations

import select
from collections.abc import Callable, Generator, Iterable
from contextlib import AbstractContextManager, nullcontext
from time import monotonic
from typing import TYPE_CHECKING, Protocol, TypeVar, cast

from rtkit.closing import Closing
from rtkit.errors import Malformed
from rtkit.link import stopping

if TYPE_CHECKING:
    from rtkit.deployment.plan_watch import PlanWatch
    from rtkit.rtc.names import Path
    from rtkit.tree.client import Tree
    from rtkit.tree.view import TreeNode

T = TypeVar("T")
Stream = Generator[T, None, None]
"""Values as they come; `close` ends that, as leaving a loop over it does."""
Notify = Callable[[str], object]
"""Receives what a command would tell on stderr."""


class Session(Protocol):
    """The means that operations get of whoever asks for them.

    Attributes:
        name: Names the run where others see it, as at a plan lock.
        timeout_s: Time-out of each call [s].
        is_strict: Take warnings for errors.
        watch: Receives plans and what becomes of their steps, as records; None for lines.
    """

    name: str
    timeout_s: float
    is_strict: bool
    watch: PlanWatch | None

    @property
    def tree(self) -> Tree:
        """The connection to the manager, made at first use."""

    @property
    def finds_managers(self) -> bool:
        """Return whether it connects to other managers that a system needs."""

    @property
    def usual_manager(self) -> str:
        """Return the manager of components whose path names none."""

    def ask(self, tree: Tree) -> None:
        """Use a connection that was made for this run; it is closed with the run."""

    def report(self, text: str) -> None:
        """Receive progress."""

    def fail(self, text: str) -> None:
        """Receive a failure that does not end the run."""

    def miss(self, text: str) -> None:
        """Receive why a part is left out, as its host cannot be reached; the rest goes on."""

    def verbose(self, text: str) -> None:
        """Receive details of progress."""

    def warn(self, texts: Iterable[str], mark: str = "warning: ") -> None:
        """Receive warnings about a request before it is carried out.

        Raises:
            Malformed: There are any, and they are to be taken for errors.
        """

    def path(self, typed: str) -> Path:
        """Read a path as typed."""

    def root(self, path: Path, *, is_deep: bool) -> tuple[TreeNode, str]:
        """Return the tree as far as a path shows it, and the host that ``localhost`` means."""

    def counting(self, title: str) -> AbstractContextManager[Callable[[int, int], None]]:
        """Return a context with what receives how many actions are done, of how many."""

    def report_silent_servers(self, done: str) -> int:
        """Report permanent servers of the tree that do not answer; return the exit status."""

    def wait_for(self, sources: Iterable[int], until: float | None) -> set[int]:
        """Wait until descriptors are readable and return those; none when the time is up.

        Raises:
            BrokenPipeError: Nobody reads the results any more.
        """

    def close(self) -> None:
        """End the connection that this run made."""


def begun(values: Generator[T | None, None, None]) -> Stream[T]:
    """Return a generator that is ready: what it waits for is not missed from now on.

    The first value of `values`, None, says that it is.
    """
    next(values)
    return cast("Stream[T]", values)


class ScriptSession(Closing):
    """One operation of a script; see `Session`.

    The connection of the script stays open when it is closed.
    """

    def __init__(
        self, tree: Tree, notify: Notify, name: str = "script", *, is_strict: bool = False
    ) -> None:
        self.name = name
        self.timeout_s = tree.timeout_s
        self.is_strict = is_strict
        self.watch: PlanWatch | None = None
        self.finds_managers = True
        self.usual_manager = tree.manager
        self._notify = notify
        self._of_script = tree
        self._own: Tree | None = None
        self._is_stale = False

    @property
    def tree(self) -> Tree:
        """The connection of the script, or one made for this operation."""
        if self._own is None and self._is_stale:
            from rtkit.tree.connect import connect

            self._own = connect(self.usual_manager, self.timeout_s)
        return self._own if self._own is not None else self._of_script

    def ask(self, tree: Tree) -> None:
        """See `Session.ask`."""
        self._own = tree

    def close(self) -> None:
        """See `Session.close`; afterwards the manager is connected to anew."""
        if self._own is not None:
            self._own.close()
            self._own = None
        self._is_stale = True

    def report(self, text: str) -> None:
        """See `Session.report`."""
        self._notify(text)

    fail = miss = report

    def verbose(self, text: str) -> None:
        """See `Session.verbose`; scripts get no details."""

    def warn(self, texts: Iterable[str], mark: str = "warning: ") -> None:
        """See `Session.warn`."""
        found = list(texts)
        if found and self.is_strict:
            raise Malformed("; ".join(found))
        for text in found:
            self._notify(f"{mark}{text}")

    def path(self, typed: str) -> Path:
        """See `Session.path`."""
        from rtkit.rtc.names import parse_path
        from rtkit.tree.api import as_text

        return parse_path(as_text(typed, "a path"))

    def root(self, path: Path, *, is_deep: bool) -> tuple[TreeNode, str]:
        """See `Session.root`."""
        from rtkit.tree.view import build

        listing = self.tree.listing()
        return build(listing), listing.host

    def counting(self, title: str) -> AbstractContextManager[Callable[[int, int], None]]:
        """See `Session.counting`."""
        return nullcontext(lambda _done, _total: None)

    def report_silent_servers(self, done: str) -> int:
        """See `Session.report_silent_servers`; scripts look at this host only."""
        return 0

    def wait_for(self, sources: Iterable[int], until: float | None) -> set[int]:
        """See `Session.wait_for`.

        Raises:
            Stopped: A stop was requested.
        """
        poll = select.poll()
        for each in (*sources, *stopping.descriptors()):
            poll.register(each, select.POLLIN)
        wait_ms = None if until is None else max(0.0, until - monotonic()) * 1000
        ready = {each for each, _ in poll.poll(wait_ms)}
        stopping.check()
        return ready
