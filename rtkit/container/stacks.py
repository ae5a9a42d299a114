"""Stacks of processes: written by the process itself, read by its manager.

A slave that is asked over its connection writes them itself, on the thread that receives: it
has the interpreter lock then, so no frame changes while it is looked at. Only one that does not
answer is sent a signal, because something holds that lock, and so no frame changes either. A signal
at other times could crash the slave: its handler walks frames that other threads are just leaving.

They are written behind the heartbeats of the process (see `rtkit.container.heartbeats`).
"""

from __future__ import annotations

import os
import re
import signal
import sys
import sysconfig
from types import FrameType

from rtkit.container.heartbeats import STACKS_AT, heartbeats_path

STACK_SIGNAL = signal.SIGUSR1
"""Signal at which a slave writes its stacks, whichever thread holds the interpreter lock."""

ASK = "stacks"
"""Operation by which a slave is asked to write its stacks."""

_FRAME = re.compile(r'  File "(.+)", line (\d+) in (.+)')
_OURS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
_LIBRARIES = (
    f"{_OURS}{os.sep}",
    f"{sysconfig.get_path('stdlib')}{os.sep}",
    f"{sysconfig.get_path('purelib')}{os.sep}",
    "<frozen ",
)
_DEBUGGERS = ("bdb.py", "pdb.py", "pydevd.py")
"""Files whose code runs while a thread stands at a breakpoint: of pdb and its kin, of debugpy."""
_DEPTH = 100
"""How many frames of a thread are written, innermost first: as many as `faulthandler` writes."""


def open_stacks(pattern: str, pid: int) -> int:
    """Return a descriptor to write stacks to; what is there already may go at any time.

    Args:
        pattern: Of the data sockets of processes.
        pid: Of the process, which has heartbeats.
    """
    flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_CLOEXEC
    return os.open(heartbeats_path(pattern, pid), flags, 0o600)


def forget_stacks(pattern: str, pid: int) -> None:
    """Drop what a process has written.

    Raises:
        OSError: It has no heartbeats any more.
    """
    os.truncate(heartbeats_path(pattern, pid), STACKS_AT)


def read_stacks(pattern: str, pid: int) -> str:
    """Return what a process has written since that was dropped last; "" if it cannot be read."""
    try:
        with open(heartbeats_path(pattern, pid), "rb") as file:
            file.seek(STACKS_AT)
            return file.read().decode("utf-8", "replace")
    except OSError:
        return ""


def write_stacks(descriptor: int) -> None:
    """Write the stacks of all threads of this process, in the form of `faulthandler`.

    Its own function would do for up to a hundred threads; an active component is one.
    """
    frames = sys._current_frames()  # noqa: SLF001 - which is meant for this
    text = "".join(_text(*each) for each in frames.items())
    os.write(descriptor, text.encode("utf-8", "backslashreplace"))


def _text(thread: int, innermost: FrameType) -> str:
    lines = [f"Thread 0x{thread:016x} (most recent call first):"]
    frame: FrameType | None = innermost
    while frame is not None and len(lines) <= _DEPTH:
        code = frame.f_code
        lines.append(f'  File "{code.co_filename}", line {frame.f_lineno} in {code.co_name}')
        frame = frame.f_back
    return "\n".join(lines) + "\n\n"


def place_of(stacks: str, thread: int, *, must_be_own: bool = False) -> str:
    """Return ``file.py:12 in name`` of a thread's innermost frame that is a component's own.

    Code of libraries and of rtkit is passed over, so that the line is one its author can mend;
    where there is no other, the innermost frame is returned unless it must be a component's.
    """
    frames = _frames(stacks, thread)
    own = [frame for frame in frames if not frame[0].startswith(_LIBRARIES)]
    for file, number, name in own[:1] or ([] if must_be_own else frames[:1]):
        return f"{os.path.basename(file)}:{number} in {name}"
    return ""


def is_in_debugger(stacks: str, thread: int) -> bool:
    """Return whether a debugger has stopped a thread in a callback; its own frames do not count."""
    for file, _, name in _frames(stacks, thread):
        if name == "attempt" and file.startswith(_OURS):
            break
        if os.path.basename(file) in _DEBUGGERS:
            return True
    return False


def _frames(stacks: str, thread: int) -> list[tuple[str, str, str]]:
    """Return file, line and function of each frame of a thread, innermost first."""
    _, _, rest = stacks.partition(f"hread 0x{thread:016x}")
    frames = []
    for line in rest.splitlines()[1:]:
        match = _FRAME.fullmatch(line)
        if match is None:
            break
        file, number, name = match.groups()
        frames.append((file, number, name))
    return frames
