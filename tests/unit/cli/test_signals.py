"""Signals that another thread than the main one takes."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading

from rtkit.cli.shared.signals import waking_main

BOUND_S = 30.0
AT_EACH_LINE = """
import signal, sys
from rtkit.cli.shared.signals import ended_by_sigterm
left = 40
def trace(frame, event, arg):
    global left
    if left:
        left -= 1
        signal.raise_signal(signal.SIGTERM)
    return trace
with ended_by_sigterm() as ended:
    sys.settrace(trace)
    ended.wait()
    sys.settrace(None)
print("ended", ended.is_set(), left)
"""


def test_a_signal_that_another_thread_takes_ends_the_wait_of_the_main_thread() -> None:
    is_heard, is_over = threading.Event(), threading.Event()
    other = threading.Thread(target=is_over.wait, args=(BOUND_S,))
    other.start()
    assert other.ident is not None
    former = signal.signal(signal.SIGTERM, lambda *_: is_heard.set())
    try:
        with waking_main():
            for _ in range(20):
                is_heard.clear()
                signal.pthread_kill(other.ident, signal.SIGTERM)
                assert is_heard.wait(BOUND_S)
    finally:
        signal.signal(signal.SIGTERM, former)
        is_over.set()
        other.join()
    assert signal.getsignal(signal.SIGURG) == signal.SIG_DFL


def test_a_signal_that_comes_while_another_is_handled_holds_nothing_up() -> None:
    done = subprocess.run(
        [sys.executable, "-c", AT_EACH_LINE],
        capture_output=True,
        text=True,
        timeout=BOUND_S,
        check=True,
    )
    assert done.stdout.startswith("ended True"), done.stderr
