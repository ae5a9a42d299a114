"""Delivers signals to the main thread, whichever thread the kernel gives them to."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_NUDGE = signal.SIGURG
_AGAIN_S = 0.05


@contextmanager
def heard_by_main() -> Iterator[None]:
    """Interrupt the waits of the main thread, which calls this, when another takes a signal.

    A handler runs on the main thread only, when its wait ends; a signal that another thread takes
    (transports have many) does not end it. So a thread that reads the signals sends the main
    thread one of its own, again until that is heard: it may come just before the wait begins.
    """
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    main, is_heard = threading.get_ident(), threading.Event()

    def relay() -> None:
        while numbers := os.read(reading, 512):
            if all(number == _NUDGE for number in numbers):
                continue
            is_heard.clear()
            while not is_heard.is_set():
                signal.pthread_kill(main, _NUDGE)
                is_heard.wait(_AGAIN_S)

    former = signal.signal(_NUDGE, lambda *_: is_heard.set())
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    thread = threading.Thread(target=relay, name="signals", daemon=True)
    thread.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(writing)
        is_heard.set()
        thread.join()
        os.close(reading)
        signal.signal(_NUDGE, former)
