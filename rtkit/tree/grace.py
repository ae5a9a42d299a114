"""Grace period: shields a call to a busy manager from an interruption."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event, Thread
from typing import TypeVar

from rtkit.deployment.site import UNFINISHED
from rtkit.link import stopping

T = TypeVar("T")

GRACE_S = 5.0
"""How long a batch under way may still run after an interruption [s]."""


def uninterrupted(call: Callable[[], T]) -> T:
    """Return the result of `call`; an interruption waits for it first, up to `GRACE_S`.

    A manager goes on with a batch whose client went away. Only when it has answered is it known
    what there is to be taken back.

    Raises:
        KeyboardInterrupt: There was an interruption; the call has ended or had its grace. Or a stop
            was requested before, and it was not begun.
    """
    stopping.check()
    ended = Event()
    outcome: list[T] = []
    failure: list[BaseException] = []

    def work() -> None:
        try:
            outcome.append(call())
        except BaseException as error:
            failure.append(error)
        finally:
            ended.set()

    try:
        Thread(target=work, daemon=True).start()
        ended.wait()
    except KeyboardInterrupt:
        if not ended.wait(GRACE_S):
            raise KeyboardInterrupt(UNFINISHED) from None
        raise
    if failure:
        raise failure[0]
    return outcome[0]
