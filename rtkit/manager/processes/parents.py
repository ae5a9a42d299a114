"""What the kernel does about parents and children, as far as Python has no function for it."""

from __future__ import annotations

import ctypes
import os
import signal

_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36
_libc = ctypes.CDLL(None, use_errno=True)


def become_subreaper() -> None:
    """Have orphans of this process's descendants become its children.

    Raises:
        OSError: The kernel refuses.
    """
    _control(_PR_SET_CHILD_SUBREAPER, 1)


def die_with(parent: int) -> None:
    """Have this process be killed when the one that forked it ends, from its only thread."""
    _control(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)  # it ended before that was said


def outlive_parent() -> None:
    """Have this process run on when the one that forked it ends."""
    _control(_PR_SET_PDEATHSIG, 0)


def _control(option: int, value: int) -> None:
    if _libc.prctl(option, value, 0, 0, 0):
        raise OSError(ctypes.get_errno(), f"prctl {option} failed")
