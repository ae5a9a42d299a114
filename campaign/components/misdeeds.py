"""What user code may do wrong, by a name for each."""

from __future__ import annotations

import ctypes
import os
import random
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import NoReturn

SLOW_S = 0.3
"""Within any time-out of the campaign [s]."""


class NoTextError(Exception):
    """An exception that cannot be shown."""

    def __str__(self) -> str:
        raise ValueError("no text")


def fail(error: BaseException) -> NoReturn:
    """Raise something."""
    raise error


def recur() -> None:
    """Call itself for ever."""
    recur()


async def wait() -> None:
    """Do what nobody awaits."""


def change_process() -> None:
    """Change what all components of a process share."""
    os.chdir("/")
    os.umask(0o077)
    random.seed(0)
    sys.setrecursionlimit(5000)
    for stream in (sys.stdout, sys.stderr):
        stream.close()


def in_threads(work: Callable[[], object]) -> None:
    """Have threads do something."""
    for _ in range(20):
        threading.Thread(target=work, daemon=True).start()


MISDEEDS: Mapping[str, Callable[[], object]] = {
    "raise": lambda: fail(RuntimeError("told to")),
    "SystemExit": sys.exit,
    "KeyboardInterrupt": lambda: fail(KeyboardInterrupt()),
    "no text": lambda: fail(NoTextError()),
    "recursion": recur,
    "memory": lambda: bytearray(1 << 60),
    "coroutine": wait,
    "slow": lambda: time.sleep(SLOW_S),
    "hang": lambda: time.sleep(1000),
    "exit": lambda: os._exit(3),
    "abort": os.abort,
    "segfault": lambda: ctypes.string_at(0),
    "in a thread": lambda: in_threads(lambda: os._exit(4)),
    "prints": lambda: [print("x" * 200) for _ in range(2000)],
    "threads": lambda: in_threads(lambda: fail(RuntimeError("in a thread"))),
    "process": change_process,
}
"""What code does when it is told to; what is returned is its result."""
