"""Sites: the few calls that a plan needs of one manager, or of several as one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Protocol, TypeVar

if TYPE_CHECKING:
    from rtkit.deployment.actions import Action, Result
    from rtkit.deployment.facts import Snapshot

T = TypeVar("T")

UNFINISHED = "the manager has not answered yet"
"""Text of the interruption of a call that had not ended after its grace."""


class Site(Protocol):
    """One manager, or several as one; every call may raise Unreachable."""

    def snapshot(self) -> Snapshot:
        """Return everything that is known."""
        ...

    def remains(self) -> Snapshot:
        """Return what can still be seen after a failure."""
        ...

    def apply(self, actions: Sequence[Action], *, is_ordered: bool = True) -> tuple[Result, ...]:
        """Have a batch performed and return the result of each action."""
        ...

    def start_manager(self, manager: str) -> None:
        """Start a manager that does not run."""
        ...

    def end_started(self) -> list[str]:
        """End the managers that were started; return those that hold something and run on."""
        ...


class Careful(Protocol):
    """Makes a call of which no interruption may lose the result."""

    def __call__(self, call: Callable[[], T]) -> T:
        """Return the result of `call`."""
        ...


def at_once(call: Callable[[], T]) -> T:
    """Make a call where nobody interrupts."""
    return call()
