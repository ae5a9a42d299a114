"""Delivers signals to the main thread, whichever took them, and changes of the terminal's size."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from queue import Empty, SimpleQueue
from types import FrameType

_NUDGE = signal.SIGURG
_AGAIN_S = 0.05


@contextmanager
def waking_main() -> Iterator[None]:
    """Interrupt the waits of the main thread, which calls this, when another takes a signal.

    A handler runs on the main thread only, when its wait ends; a signal that another thread takes
    (transports have many) does not end it. So a thread that reads the signals sends the main
    thread one of its own, again until that is heard: it may come just before the wait begins.
    """
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    main, received = threading.get_ident(), SimpleQueue[None]()

    def relay() -> None:
        while numbers := os.read(reading, 512):
            if all(number == _NUDGE for number in numbers):
                continue
            while not received.empty():
                received.get()  # of a nudge that came late
            is_received = False
            while not is_received:
                signal.pthread_kill(main, _NUDGE)
                with suppress(Empty):
                    received.get(timeout=_AGAIN_S)
                    is_received = True

    former = signal.signal(_NUDGE, lambda *_: received.put(None))
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    thread = threading.Thread(target=relay, name="signals", daemon=True)
    thread.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(writing)
        received.put(None)
        thread.join()
        os.close(reading)
        signal.signal(_NUDGE, former)


class SteadyWork:
    """Work that signals do not end half-way: use as a context manager for each piece of it.

    A signal that comes within a piece is delivered at its end, others at once, each to the handler
    that there was. A signal that is ignored, or ends the process, stays so.

    Args:
        numbers: Of the signals.
    """

    def __init__(self, *numbers: int) -> None:
        self._came: list[int] = []
        self._is_at_work = False
        self._handlers = {each: signal.getsignal(each) for each in numbers}
        for number, handler in self._handlers.items():
            if callable(handler):
                signal.signal(number, self._take)

    def _take(self, number: int, frame: FrameType | None) -> None:
        handler = self._handlers[number]
        if self._is_at_work:
            self._came.append(number)
        elif callable(handler):
            handler(number, frame)

    def __enter__(self) -> None:
        self._is_at_work = True

    def __exit__(self, *error: object) -> None:
        self._is_at_work = False
        while self._came:
            signal.raise_signal(self._came.pop(0))

    def close(self) -> None:
        """Put the handlers back, but for those that were changed meanwhile."""
        for number, handler in self._handlers.items():
            if signal.getsignal(number) == self._take:
                signal.signal(number, handler)


class End:
    """Event that a handler of signals may set at any moment, also within itself and within `wait`.

    One of `threading` waits for itself for ever when its lock is held just then: it was set by a
    first SIGTERM when a second one came.
    """

    def __init__(self) -> None:
        self._signals = SimpleQueue[None]()

    def set(self) -> None:
        """Tell that it is over; `SimpleQueue.put` is reentrant."""
        self._signals.put(None)

    def is_set(self) -> bool:
        """Return whether it is over."""
        return not self._signals.empty()

    def wait(self) -> None:
        """Wait until it is over."""
        self._signals.put(self._signals.get())


@contextmanager
def ended_by_sigterm() -> Iterator[End]:
    """Yield an event that SIGTERM sets; it is heard whichever thread takes it, as Ctrl-C is."""
    ended = End()
    signal.signal(signal.SIGTERM, lambda number, frame: ended.set())
    with waking_main():
        yield ended


_DISTURBANCES = (signal.SIGWINCH, signal.SIGCONT)
"""Another size; or the shell has had the terminal meanwhile (Ctrl-Z, fg)."""


class ResizeWakeup:
    """Wakeup event: its descriptor is readable from `ring` until `take`."""

    def __init__(self) -> None:
        self._event = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._event

    def ring(self) -> None:
        """Set the event, from any thread or a signal handler; a closed one is ignored."""
        with suppress(OSError, ValueError):
            os.eventfd_write(self._event, 1)

    def take(self) -> bool:
        """Return whether the event was set since the last call, and clear it."""
        try:
            os.eventfd_read(self._event)
        except BlockingIOError:
            return False
        return True

    def close(self) -> None:
        """Close the descriptor."""
        os.close(self._event)
        self._event = -1


@contextmanager
def resizing(is_terminal: bool) -> Iterator[ResizeWakeup]:
    """Yield an event that is set when a terminal on stdout must be written anew."""
    wakeup = ResizeWakeup()
    before = {
        number: signal.signal(number, lambda *_: wakeup.ring())
        for number in (_DISTURBANCES if is_terminal else ())
    }
    try:
        yield wakeup
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        wakeup.close()
