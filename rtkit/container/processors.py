"""Binds the threads of this process to processors: all threads, and those of contexts.

A new thread begins where the one that made it runs, so the thread of a context says where it
belongs once any context of this process has processors of its own.
"""

from __future__ import annotations

import os
from _thread import get_native_id
from collections.abc import Iterable

from rtkit.errors import Refused
from rtkit.rtc.context_settings import CPU_AFFINITY

_own: set[int] = set()
"""Threads that have processors of their own."""

_is_in_use = False


def use(wanted: frozenset[int]) -> None:
    """Have all threads of this process run on these processors, but for those with own ones.

    Raises:
        Refused: There is none of them.
    """
    for thread in os.listdir("/proc/self/task"):
        if int(thread) in _own:
            continue
        try:
            os.sched_setaffinity(int(thread), wanted)
        except ProcessLookupError:
            continue
        except OSError as error:
            raise Refused(_missing(wanted, error)) from error


def begin(text: str) -> str:
    """Have the present thread, which drives a context, run where it belongs; return why not."""
    global _is_in_use
    if not text and not _is_in_use:
        return ""
    _is_in_use = True
    if text:
        _own.add(get_native_id())
    else:
        end()
    wanted: Iterable[int] = os.sched_getaffinity(os.getpid())
    if text:
        from rtkit.settings.values import processors

        wanted = processors(text)
    try:
        os.sched_setaffinity(0, wanted)
    except OSError as error:
        return f"{CPU_AFFINITY}: {_missing(wanted, error)}"
    return ""


def end() -> None:
    """Forget the present thread."""
    _own.discard(get_native_id())


def _missing(wanted: Iterable[int], error: OSError) -> str:
    there = _text(os.sched_getaffinity(0))
    return f"cannot run on processors {_text(wanted)} ({error.strerror}; this process has {there})"


def _text(numbers: Iterable[int]) -> str:
    return ",".join(map(str, sorted(numbers)))
