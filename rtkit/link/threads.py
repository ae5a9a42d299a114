"""Starts threads and reports when the host, or the user's limit, allows no more of them."""

from __future__ import annotations

import threading
from collections.abc import Callable

from rtkit.errors import Refused


class OwnThread(threading.Thread):
    """A thread of rtkit: not labelled as one of the component whose code may be starting it."""


def start_thread(work: Callable[[], object], name: str) -> threading.Thread:
    """Do something on a thread of its own, which does not keep the process from its end.

    Raises:
        Refused: None can be had now.
    """
    thread = OwnThread(target=work, name=name, daemon=True)
    try:
        thread.start()
    except RuntimeError as error:
        raise Refused(f"no thread can be had for {name}: {error}") from error
    return thread
