"""Hands events of another thread over to the loop, holding no more than a queue may hold."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from rtkit.property.messages import PropertyEvent
from rtkit.property.naming import parse_parameters
from rtkit.property.subscription import LONGEST_QUEUE
from rtkit.serving.event_loop import PropertyEventLoop


class LoopInbox:
    """Inbox of the events of one subscription.

    Args:
        options: Parameters of the listening; the queue is one of them.
        hear: Called on the loop with each event.
    """

    def __init__(
        self, host: PropertyEventLoop, options: str, hear: Callable[[PropertyEvent], object]
    ) -> None:
        self._host = host
        self._hear = hear
        self._events: deque[PropertyEvent] = deque(maxlen=_queue_of(options))
        self._dropped = 0
        self._is_posted = False
        self._lock = threading.Lock()

    def put(self, event: PropertyEvent, lost: int = 0) -> None:
        """Take an event, before which some were lost; a full queue drops its oldest."""
        with self._lock:
            if self._events.maxlen != 1:
                event = event._replace(dropped=event.dropped + lost)
            if len(self._events) == self._events.maxlen and self._events.maxlen > 1:
                self._dropped += 1 + self._events[0].dropped
            self._events.append(event)
            if self._is_posted:
                return
            self._is_posted = True
        self._host.post(self._empty)

    def _empty(self) -> None:
        with self._lock:
            events, dropped = list(self._events), self._dropped
            self._events.clear()
            self._dropped, self._is_posted = 0, False
        if dropped:
            events[0] = events[0]._replace(dropped=events[0].dropped + dropped)
        for event in events:
            self._hear(event)


def _queue_of(options: str) -> int:
    queue = (parse_parameters(options).get("queue") or "1") if options else "1"
    return max(1, min(int(queue), LONGEST_QUEUE)) if queue.isdecimal() else 1
