"""Samples the first moments of forked processes, which end before another process can look.

Python imports this where ``bench.flames`` has put its folder before others. In a child of a fork
the main thread notes its stack each half millisecond on the clock, so waits are seen, too.
"""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

INTERVAL_S = 0.0005
_SAMPLES = 40
"""How many are taken of a child: 20 ms."""
_LIBRARY = f"/python{sys.version_info[0]}.{sys.version_info[1]}/"


def _begin(folder: str) -> None:
    file = os.open(os.path.join(folder, f"{os.getpid()}.stacks"), os.O_WRONLY | os.O_CREAT, 0o600)
    left = _SAMPLES

    def note(_number: int, frame: FrameType | None) -> None:
        nonlocal left
        names = []
        while frame is not None:
            code = frame.f_code
            names.append(f"{code.co_qualname} ({_short(code.co_filename)}:1)")
            frame = frame.f_back
        os.write(file, (";".join(reversed(names)) + " 1\n").encode())
        left -= 1
        if not left:
            signal.setitimer(signal.ITIMER_REAL, 0)

    signal.signal(signal.SIGALRM, note)
    signal.setitimer(signal.ITIMER_REAL, INTERVAL_S, INTERVAL_S)


def _short(path: str) -> str:
    """Return a path as py-spy tells it: below the folder that Python has it from."""
    for mark in ("/site-packages/", _LIBRARY):
        if mark in path:
            return path.rpartition(mark)[2]
    at = path.rfind("/rtkit/")
    return path[at + 1 :] if at >= 0 else path


if "RTKIT_BENCH_STACKS" in os.environ:
    os.register_at_fork(after_in_child=lambda: _begin(os.environ["RTKIT_BENCH_STACKS"]))
