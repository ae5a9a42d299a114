"""Calls user code for a service: guarded, beside its loop, or awaited; no other module does.

Readers, writers, getters, setters, actions and what lists names pass here. A service by itself
calls them at once; one with endpoints has `rtkit.serving.workers`.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from types import CoroutineType
from typing import Any, TypeGuard

from rtkit.errors import Refused
from rtkit.guard import GuardedResult, guarded, kind_and_text, text_of
from rtkit.property.codes import PropertyError, code_of
from rtkit.property.messages import Answer

Work = Callable[[], object]
Finished = Callable[[object, BaseException | None], None]
Cancel = Callable[[], object]


class UserCode:
    """Calls user code for one process; this one on the thread of the requester, at once."""

    def call(self, work: Work) -> GuardedResult:
        """Call something now, on this thread, and await what it returns."""
        outcome = guarded(work)
        if isinstance(outcome.error, KeyboardInterrupt):
            raise outcome.error  # this may be the main thread, and the user at its terminal
        if is_coroutine(outcome.result):
            return guarded(lambda: self.awaited(outcome.result, lambda cancel: None))
        return outcome

    def later(self, lane: str, work: Work, refuse: Callable[[Answer], object], wait: float) -> None:
        """Do something that calls user code, in its turn.

        Args:
            lane: Of several in one lane each begins when the one before has ended.
            work: Work to do; it owns the service but while it calls user code.
            refuse: Takes the reason when it cannot be done, or has not ended in time.
            wait: How long that is [s]; 0 for as long as usual.
        """
        work()

    def start(self, work: Work, finished: Finished) -> None:
        """Run an action; `finished` takes its outcome as the owner of the service.

        Raises:
            PropertyError: ``busy``: very many run already.
        """
        outcome = self.call(work)
        finished(outcome.result, outcome.error)

    def refuse_after(self, wait: float, refuse: Callable[[Answer], object]) -> Callable[[], object]:
        """Refuse something that has not ended after some time [s]; return what takes that back."""
        return lambda: None  # at once: all has ended before anybody could ask

    def post(self, work: Work) -> None:
        """Do something soon as the owner of the service; from any thread."""
        work()

    def awaited(
        self, coroutine: Coroutine[Any, Any, object], cancellable: Callable[[Cancel], object]
    ) -> object:
        """Await a coroutine on a loop of the service, and wait until it has ended.

        Args:
            coroutine: Coroutine to await.
            cancellable: Is given what cancels it; then it returns None.
        """
        import asyncio

        return asyncio.run(coroutine)


def is_coroutine(thing: object) -> TypeGuard[Coroutine[Any, Any, object]]:
    """Return whether something is what a coroutine function returns."""
    return isinstance(thing, CoroutineType)


def result_of(outcome: GuardedResult, bad: tuple[type[BaseException], ...] = ()) -> Any:
    """Return the result of a call.

    Args:
        outcome: Result of the call.
        bad: Errors that say that the value is wrong.

    Raises:
        PropertyError: As it was raised, ``bad-value``, or ``internal``.
    """
    error = outcome.error
    if error is None:
        return outcome.result
    if isinstance(error, PropertyError | Unfolded):
        raise error
    if isinstance(error, bad):
        raise PropertyError("bad-value", text_of(error)) from error
    if isinstance(error, Refused):
        raise PropertyError(code_of(error), text_of(error)) from error
    raise PropertyError("internal", kind_and_text(error)) from error


class Unfolded(Exception):
    """Property that turned out to hold an object with properties of its own: look it up again."""


AT_ONCE = UserCode()
