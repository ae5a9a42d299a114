"""Prepares the process of a console script: Ctrl-C, a closed pipe, an odd stdout."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
import os
import sys
from types import FrameType
from typing import NoReturn, TextIO

INTERRUPTED = 130
BROKEN_PIPE = 141
_MOMENT_S = 0.001
_AGAIN_S = 0.05


def prepare() -> None:
    """Make stdout fit to write to, characters that its encoding lacks as escapes."""
    if sys.stdout is None:
        sys.stdout = _closed()
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="backslashreplace")


def _closed() -> TextIO:
    """Return a stream that fails on writing, as a closed stdout does, and occupies a descriptor."""
    return open(os.open(os.devnull, os.O_RDONLY), "w")


def enable_interrupts() -> None:
    """Make Ctrl-C raise KeyboardInterrupt, which `rtkit.cli` has put off until now."""
    if _signal.getsignal(_signal.SIGINT) == _signal.SIG_DFL:
        sys.unraisablehook = _not_lost
        _signal.signal(_signal.SIGINT, _signal.default_int_handler)


def _not_lost(failure: sys.UnraisableHookArgs) -> None:
    """Interrupt again, a moment later, after an interruption of code that cannot raise.

    The callbacks at the end of a module's import are such code.
    """
    if failure.exc_type is KeyboardInterrupt:
        _signal.signal(_signal.SIGALRM, _again)
        _signal.setitimer(_signal.ITIMER_REAL, _MOMENT_S, _AGAIN_S)
    else:
        sys.__unraisablehook__(failure)


def _again(number: int, frame: FrameType | None) -> None:
    """Interrupt, unless a busy host is still in the hook, where that would be lost: next time."""
    if frame is None or frame.f_code is not _not_lost.__code__:
        _signal.setitimer(_signal.ITIMER_REAL, 0)
        _signal.default_int_handler(number, frame)


def die_interrupted() -> NoReturn:
    """End as the signal would have ended it, so that a shell ends the script it was called from.

    Threads of the transport that are still at work do not survive an orderly exit.
    """
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
    _signal.raise_signal(_signal.SIGINT)
    os._exit(INTERRUPTED)  # the signal is blocked, so the kill above had no effect


def end(status: int) -> NoReturn:
    """End the process now; all output must be flushed.

    An orderly end of the interpreter looks for cycles first, a sixth of the time of a whole rtls,
    and aborts where a thread of the transport comes back to it meanwhile.
    """
    os._exit(status)


def leave_pipe() -> None:
    """Discard unwritten output: nobody reads it, and flushing it at exit would fail loudly."""
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())


def give_up() -> None:
    """Discard output that cannot be written, once that is reported."""
    try:
        sys.stdout.flush()
    except OSError:
        leave_pipe()


def write(name: str, text: str) -> int:
    """Print a text that needs no command, and return the exit status."""
    prepare()
    try:
        print(text, flush=True)
    except BrokenPipeError:
        leave_pipe()
        return BROKEN_PIPE
    except OSError as error:
        print(f"{name}: {error.strerror}", file=sys.stderr)
        leave_pipe()
        return 1
    return 0
