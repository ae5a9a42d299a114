"""The thread of a process that takes what arrives at its sockets, and lends them to readers.

A reader that waits for a value takes it from the socket itself, because a thread between them
would cost two more wake-ups for each value. Its socket stays lent while it comes back soon.
"""

from __future__ import annotations

import select
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

from rtkit.link.threads import start_thread
from rtkit.link.wakeup import Wakeup

_BACK_S = 0.02
"""How long a socket stays lent to a reader that does not come back [s]."""
_JOIN_S = 1.0


class Lent(Protocol):
    """A source that a reader may read by itself."""

    def look(self) -> bool:
        """Return whether it is to be looked after on; else the loop, or a reader, has it."""


class SocketLoop:
    """Calls functions when descriptors are ready, on a thread that starts with the first one."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._epoll = select.epoll()
        self._wakeup = Wakeup()
        self._epoll.register(self._wakeup, select.EPOLLIN)
        self._ready: dict[int, Callable[[], object]] = {}
        self._lent: set[Lent] = set()
        self._look_at = 0.0
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._is_closed = False

    def add(self, descriptor: int, ready: Callable[[], object], events: int) -> None:
        """Call `ready` whenever one of the events is there.

        Raises:
            Refused: No thread can be had.
        """
        with self._lock:
            if self._is_closed:
                return
            self._ready[descriptor] = ready
            self._epoll.register(descriptor, events)
            if self._thread is None:
                try:
                    self._thread = start_thread(self._run, self._name)
                except BaseException:
                    self._epoll.unregister(descriptor)
                    del self._ready[descriptor]
                    raise

    def modify(self, descriptor: int, events: int) -> None:
        """Call the function of a descriptor at other events from now on; at none, if 0."""
        with self._lock, suppress(OSError):
            if descriptor in self._ready and not self._is_closed:
                self._epoll.modify(descriptor, events)

    def remove(self, descriptor: int) -> None:
        """Call nothing more; one call may be under way."""
        with self._lock:
            if self._ready.pop(descriptor, None) is not None and not self._is_closed:
                with suppress(OSError):
                    self._epoll.unregister(descriptor)

    def lend(self, source: Lent) -> None:
        """Look after a source whose reader reads by itself from now on."""
        with self._lock:
            self._lent.add(source)
        self._wakeup.ring()

    def close(self) -> None:
        """End the thread, and wait for it unless this is it."""
        with self._lock:
            if self._is_closed:
                return
            self._is_closed = True
            thread = self._thread
        self._wakeup.ring()
        if thread is None:
            self._end()
        elif thread is not threading.current_thread():
            thread.join(_JOIN_S)

    def _run(self) -> None:
        while not self._is_closed:
            for descriptor, _ in self._epoll.poll(_BACK_S if self._lent else None):
                ready = self._ready.get(descriptor)
                if ready is not None:
                    self._call(ready)
            self._wakeup.hush()
            if self._lent and time.monotonic() >= self._look_at:
                self._look_at = time.monotonic() + _BACK_S
                self._look_at_lent()
        self._end()

    def _call(self, ready: Callable[[], object]) -> None:
        try:
            ready()
        except Exception:  # of a listener at one port: the others go on
            import logging

            logging.getLogger(__name__).exception("%s", self._name)

    def _look_at_lent(self) -> None:
        for source in list(self._lent):
            if not source.look():
                with self._lock:
                    self._lent.discard(source)

    def _end(self) -> None:
        self._epoll.close()
        self._wakeup.close()
