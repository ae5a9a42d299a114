"""Withholds inherited descriptors and environment marks from programs that components start."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress

MARK = "RTKIT_MANAGER_PROCESS"
"""Environment variable of what components in a manager's own process start: whose it is."""

_FIRST = 3  # those before are input, output and error


def unmarked(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without the mark, for what is to outlive the manager."""
    return {key: value for key, value in environment.items() if key != MARK}


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
