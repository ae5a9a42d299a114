"""Binds the threads of this process to processors: all threads, and those of contexts.

A new thread begins where the one that made it runs, so the thread of a context says where it
belongs once any context of this process has processors of its own.
"""

from __future__ import annotations

import os
from _thread import get_native_id
from collections.abc import Iterable, Mapping

from rtkit.component.owned_contexts import CPU_AFFINITY
from rtkit.errors import Malformed, Refused
from rtkit.logs.late import late

_log = late(__name__)
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


def check(options: Mapping[str, str]) -> None:
    """Refuse processors of contexts that are not there, before a component is made.

    Raises:
        Malformed: Their list cannot be read.
        Refused: There is none of them.
    """
    from rtkit.settings.values import processors

    there = range(os.cpu_count() or 1)
    for key, text in options.items():
        if key != f"exec_cxt.{CPU_AFFINITY}" and not _is_of_context(key):
            continue
        try:
            wanted = processors(text)
        except Malformed as error:
            raise Malformed(f"{key}: {error}") from None
        if wanted.isdisjoint(there):
            raise Refused(f"{key}: no such processors: {text} (there are {_text(there)})")


def _is_of_context(key: str) -> bool:
    return key.startswith("ec.") and key.endswith(f".{CPU_AFFINITY}")


def begin(text: str) -> None:
    """Have the present thread, which drives a context, run where it belongs."""
    global _is_in_use
    if not text and not _is_in_use:
        return
    _is_in_use = True
    if text:
        _own.add(get_native_id())
    wanted: Iterable[int] = os.sched_getaffinity(os.getpid())
    if text:
        from rtkit.settings.values import processors

        wanted = processors(text)
    try:
        os.sched_setaffinity(0, wanted)
    except OSError as error:
        _log().warning("%s", _missing(frozenset(wanted), error))


def end() -> None:
    """Forget the present thread."""
    _own.discard(get_native_id())


def _missing(wanted: frozenset[int], error: OSError) -> str:
    there = _text(os.sched_getaffinity(0))
    return f"cannot run on processors {_text(wanted)} ({error.strerror}; this process has {there})"


def _text(numbers: Iterable[int]) -> str:
    return ",".join(map(str, sorted(numbers)))
