"""Makes zygote, slaves and manager subreapers: each inherits the orphans below it.

So what a component daemonises stays below its slave while that lives, and below the zygote after
that, which ends it; whatever its session and its environment are.

See decision 42.
"""

from __future__ import annotations

_PR_SET_CHILD_SUBREAPER = 36


def become_subreaper() -> None:
    """Have orphans of this process's descendants become its children; forks do not inherit it.

    Raises:
        OSError: The kernel refuses.
    """
    import ctypes  # 6 ms, which the zygote takes when nobody waits

    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0):
        raise OSError(ctypes.get_errno(), "cannot become subreaper")
