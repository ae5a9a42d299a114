"""Puts the code that slaves run together in memory.

A call counts the code that it runs, and code remembers what it met: both write to it, so each page
with code that a slave runs becomes its own. Imports leave what runs lying among what never does.

See decision 49.
"""

from __future__ import annotations

import gc
import sys
import threading
from collections.abc import Callable
from types import CodeType, FrameType, FunctionType

_Codes = dict[int, CodeType]
"""By identity: codes are equal that do the same."""


def put_together(work: Callable[[], object]) -> None:
    """Have every function that `work` calls use a copy of its code, one copy behind the other.

    The copies are as if they had never run. Objects that were frozen are so no more.
    """
    ran, copies = _ran(work), _Codes()
    gc.unfreeze()  # else none of them would be listed
    for function in gc.get_objects():
        if type(function) is FunctionType and id(function.__code__) in ran:
            function.__code__ = _copy(function.__code__, ran, copies)


def _ran(work: Callable[[], object]) -> _Codes:
    """Return the codes that `work` runs on this thread, and on those that it starts."""
    ran = _Codes()

    def note(frame: FrameType, _event: str, _argument: object) -> None:
        ran[id(frame.f_code)] = frame.f_code

    before = sys.getprofile(), threading.getprofile()
    sys.setprofile(note)
    threading.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(before[0])
        threading.setprofile(before[1])
    return ran


def _copy(code: CodeType, ran: _Codes, copies: _Codes) -> CodeType:
    if id(code) not in ran:
        return code
    if id(code) not in copies:
        consts = code.co_consts
        inner = (_copy(c, ran, copies) if isinstance(c, CodeType) else c for c in consts)
        copies[id(code)] = code.replace(co_consts=tuple(inner))
    return copies[id(code)]
