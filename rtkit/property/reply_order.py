"""Orders replies as their requests; sends those to requests with an id as soon as they come."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable


class InOrder:
    """Keeps the unanswered requests of one connection in their order.

    Args:
        put: Takes replies in the order in which they are to be sent.

    Attributes:
        waiting: How many requests are not answered.
    """

    def __init__(self, put: Callable[[bytes], object]) -> None:
        self.waiting = 0
        self._put = put
        self._queue: deque[list[bytes]] = deque()

    def expect(self, *, has_id: bool) -> Callable[[bytes], None]:
        """Note a request; return what takes its reply, once."""
        self.waiting += 1
        return self._at_once if has_id else self._in_turn()

    def _at_once(self, reply: bytes) -> None:
        self.waiting -= 1
        self._put(reply)

    def _in_turn(self) -> Callable[[bytes], None]:
        queue = self._queue
        slot: list[bytes] = []
        queue.append(slot)

        def fill(reply: bytes) -> None:
            self.waiting -= 1
            slot.append(reply)
            while queue and queue[0]:
                self._put(queue.popleft()[0])

        return fill
