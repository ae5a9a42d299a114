"""Signals that end a manager in order, or have it say where its threads are."""

from __future__ import annotations

import faulthandler
import signal
from collections.abc import Callable

from rtkit.manager.core.events import StopRequested

_STDERR = 2


def catch_signals(post: Callable[[StopRequested], object], *, is_shown: bool) -> None:
    """End in order at TERM, INT and QUIT, in the foreground also when the terminal is closed (HUP).

    QUIT first writes to stderr where every thread is, USR1 writes it and nothing else. In the
    foreground a second INT or QUIT ends at once. Signals that a shell or ``nohup`` had ignored stay
    so.

    TERM comes with the end of the machine, not from a user: desired state is kept then.
    """
    caught: list[int] = []

    def stop(number: int, _frame: object) -> None:
        is_key = number in (signal.SIGINT, signal.SIGQUIT)
        is_urgent = is_shown and is_key and bool(caught)
        caught.append(number)
        post(StopRequested(is_urgent, is_kept=number == signal.SIGTERM))

    signal.signal(signal.SIGTERM, stop)
    for number in (signal.SIGINT, signal.SIGQUIT, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, stop)
    if not is_shown:
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
    if signal.getsignal(signal.SIGQUIT) is stop:
        faulthandler.register(signal.SIGQUIT, _STDERR, all_threads=True, chain=True)
    faulthandler.register(signal.SIGUSR1, _STDERR, all_threads=True)
    signal.signal(signal.SIGCHLD, lambda *_: None)
