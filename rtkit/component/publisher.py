"""Push policies of a connector: select the queued values that a publisher sends."""

from __future__ import annotations

from collections.abc import Sized
from typing import Protocol, TypeVar

from rtkit.component.options import PushPolicy

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Queue(Sized, Protocol[T_co]):
    """The buffer that a publisher sends from."""

    def take(self) -> T_co | None:
        """Remove and return the oldest value, None when empty."""


def select(policy: PushPolicy, buffer: Queue[T], skip_count: int = 0) -> list[T]:
    """Take from `buffer` the values to send now, in order.

    ``new`` takes all and sends the newest, ``all`` sends everything, ``fifo`` the oldest one,
    ``skip`` the last of each complete group of `skip_count` + 1; an incomplete one stays queued.
    """
    queued = len(buffer)
    if policy is PushPolicy.FIFO:
        return _take(buffer, min(queued, 1))
    if policy is PushPolicy.SKIP:
        group = skip_count + 1
        return _take(buffer, queued - queued % group)[skip_count::group]
    values = _take(buffer, queued)
    return values[-1:] if policy is PushPolicy.NEW else values


def _take(buffer: Queue[T], count: int) -> list[T]:
    taken = (buffer.take() for _ in range(count))
    return [value for value in taken if value is not None]
