"""Removes shared memory that zenoh leaves in ``/dev/shm`` when a process ends, killed or not."""

from __future__ import annotations

import fcntl
import os
import re
import stat
import time
from contextlib import suppress

FOLDER = "/dev/shm"
_SEGMENT = re.compile(r"\d+\.zenoh")
_SETTLED_S = 0.1
"""How long the process that makes a segment may take to lock it [s]."""


def remove_orphans(folder: str = FOLDER) -> int:
    """Remove segments of this user that no process holds any more; return their size [byte].

    Each process that has a segment open holds a lock on it, in whatever container it runs.
    """
    freed = 0
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _SEGMENT.fullmatch(entry.name):
                freed += _removed(entry.path)
    return freed


def _removed(path: str) -> int:
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return 0
    try:
        status = os.fstat(descriptor)
        is_ours = stat.S_ISREG(status.st_mode) and status.st_uid == os.geteuid()
        if not is_ours or time.time() - status.st_ctime < _SETTLED_S:
            return 0
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.unlink(path)
    except OSError:
        return 0  # somebody holds it, or has removed it meanwhile
    else:
        return status.st_size
    finally:
        os.close(descriptor)
