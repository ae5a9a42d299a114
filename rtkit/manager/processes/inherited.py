"""What a process was given open by the one that started it, and is not to give any further."""

from __future__ import annotations

import os
from contextlib import suppress

_FIRST = 3  # those before are input, output and error


def withhold() -> None:
    """Have programs that are started from here inherit nothing that this one was given.

    What this process opened itself is not inherited anyway; but a script may have handed it the
    lock it holds, or a pipe whose end somebody waits for, and what outlives the script would keep
    them.
    """
    for name in os.listdir("/proc/self/fd"):
        descriptor = int(name)
        if descriptor >= _FIRST:
            with suppress(OSError):  # the one by which the folder was read
                os.set_inheritable(descriptor, False)
