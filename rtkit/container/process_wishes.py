"""Settings that a whole process has while the thread of one of its contexts wishes so.

They are locked memory, the mode of the garbage collector, and how soon a thread that computes lets
another one go on. Of several wishes the strictest counts, and with the last one all is as before.
"""

from __future__ import annotations

import gc
import os
import resource
import sys
import threading
from typing import NamedTuple

from rtkit.rtc.context_settings import MEMORY_LOCK, CollectorMode

USUAL_SWITCH_S = sys.getswitchinterval()
_MCL_CURRENT_AND_FUTURE = 3
_CAP_IPC_LOCK = 14
_MODES = tuple(CollectorMode)
_STOPPED = (CollectorMode.BETWEEN, CollectorMode.OFF)


class Wish(NamedTuple):
    """Wishes of one context."""

    locks_memory: bool = False
    collector: CollectorMode = CollectorMode.ON
    switch_s: float = USUAL_SWITCH_S


class ProcessWishes:
    """Wishes of the contexts at work in this process, and their effects."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._wishes: dict[object, Wish] = {}
        self._now = Wish()
        self._has_stopped_collector = False

    def state(self, key: object, wish: Wish) -> str:
        """Have a context's wish count from now on; return what the system refuses of it."""
        with self._lock:
            self._wishes[key] = wish
            why = self._apply()
        return why if wish.locks_memory else ""

    def drop(self, key: object) -> None:
        """Have a context wish for nothing."""
        with self._lock:
            if self._wishes.pop(key, None) is not None:
                self._apply()

    def _apply(self) -> str:
        wishes = self._wishes.values()
        wanted = Wish(
            any(each.locks_memory for each in wishes),
            max((each.collector for each in wishes), key=_MODES.index, default=CollectorMode.ON),
            min((each.switch_s for each in wishes), default=USUAL_SWITCH_S),
        )
        before = self._now
        if wanted.switch_s != before.switch_s:
            sys.setswitchinterval(wanted.switch_s)
        if wanted.collector is not before.collector:
            self._collect(wanted.collector)
        why = ""
        if wanted.locks_memory != before.locks_memory:
            why = _lock_memory() if wanted.locks_memory else _unlock_memory()
        self._now = wanted._replace(locks_memory=wanted.locks_memory and not why)
        return why

    def _collect(self, mode: CollectorMode) -> None:
        if mode is not CollectorMode.ON:
            freeze()
        if mode in _STOPPED and gc.isenabled():
            gc.disable()
            self._has_stopped_collector = True
        elif mode not in _STOPPED and self._has_stopped_collector:
            gc.enable()
            self._has_stopped_collector = False


def freeze() -> None:
    """Have the collector look no more through what there is, but for garbage, which goes.

    It stays so to the end: a slave has frozen what it shares with its siblings.
    """
    gc.collect()
    gc.freeze()


wishes = ProcessWishes()
"""Those of this process."""


def _lock_memory() -> str:
    """Keep all memory of this process, also that to come, in RAM; return why not."""
    limit, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    # Below a limit the lock may be had, and the next allocation of the component would fail.
    if limit != resource.RLIM_INFINITY and not _has_capability(_CAP_IPC_LOCK):
        return f"{MEMORY_LOCK}: RLIMIT_MEMLOCK is {limit // 1024} kB, it has to be unlimited"
    return _call("mlockall", _MCL_CURRENT_AND_FUTURE)


def _unlock_memory() -> str:
    return _call("munlockall")


def _call(name: str, *arguments: int) -> str:
    import ctypes

    libc = ctypes.CDLL(None, use_errno=True)
    if getattr(libc, name)(*arguments):
        return f"{MEMORY_LOCK}: {name}: {os.strerror(ctypes.get_errno())}"
    return ""


def _has_capability(number: int) -> bool:
    with open("/proc/self/status", encoding="ascii", errors="replace") as file:
        held = next((line.split()[1] for line in file if line.startswith("CapEff:")), "0")
    return bool(int(held, 16) >> number & 1)
