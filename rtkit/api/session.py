"""Session: one run of operations on a system; a command's run is one, a script's is another."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rtkit.rtc.names import Path
    from rtkit.tree.client import Tree
    from rtkit.tree.view import TreeNode


class Session(Protocol):
    """The means that operations get of whoever asks for them.

    Attributes:
        name: Names the run where others see it, as at a plan lock.
        timeout_s: Time-out of each call [s].
        is_strict: Take warnings for errors.
    """

    name: str
    timeout_s: float
    is_strict: bool

    @property
    def tree(self) -> Tree:
        """The connection to the manager, made at first use."""
        ...

    @property
    def finds_managers(self) -> bool:
        """Return whether it connects to other managers that a system needs."""
        ...

    @property
    def usual_manager(self) -> str:
        """Return the manager of components whose path names none."""
        ...

    def ask(self, tree: Tree) -> None:
        """Use a connection that was made for this run; it is closed with the run."""
        ...

    def report(self, text: str) -> None:
        """Receive progress."""
        ...

    def fail(self, text: str) -> None:
        """Receive a failure that does not end the run."""
        ...

    def verbose(self, text: str) -> None:
        """Receive details of progress."""
        ...

    def warn(self, texts: Iterable[str], mark: str = "warning: ") -> None:
        """Receive warnings about a request before it is carried out.

        Raises:
            Malformed: There are any, and they are to be taken for errors.
        """
        ...

    def path(self, typed: str) -> Path:
        """Read a path as typed."""
        ...

    def root(self, path: Path, *, is_deep: bool) -> tuple[TreeNode, str]:
        """Return the tree as far as a path shows it, and the host that ``localhost`` means."""
        ...

    def counting(self, title: str) -> AbstractContextManager[Callable[[int, int], None]]:
        """Return a context with what receives how many actions are done, of how many."""
        ...

    def report_silent_servers(self, done: str) -> int:
        """Report permanent servers of the tree that do not answer; return the exit status."""
        ...

    def wait_for(self, sources: Iterable[int], until: float | None) -> set[int]:
        """Wait until descriptors are readable and return those; none when the time is up.

        Raises:
            BrokenPipeError: Nobody reads the results any more.
        """
        ...

    def close(self) -> None:
        """End the connection that this run made."""
        ...
