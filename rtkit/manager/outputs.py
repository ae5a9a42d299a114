"""What processes write past their log, to descriptors 1 and 2: C code, programs, crashes.

It goes to a file of plain text for each process, ``.out`` beside its log: a pipe would hold a
process up whose reader is gone, or busy. A process begins its file anew and keeps the one before
it as ``.out.1``. Files that grow are cut by the manager, now and then.
"""

from __future__ import annotations

import contextlib
import os
import re

from rtkit.manager.logfile import MAX_BYTES, open_private

_TAIL = 4096
_MAX_LINES = 3
_MAX_TEXT = 300
_FRAME = re.compile(r'  File "(.+)", line (\d+) in (.+)')


def redirect(path: str) -> None:
    """Have descriptors 1 and 2 of this process lead to its own file; on failure they stay."""
    with contextlib.suppress(OSError):
        if os.stat(path, follow_symlinks=False).st_size:
            os.replace(path, f"{path}.1")
    with contextlib.suppress(OSError):
        descriptor = open_private(path)
        os.dup2(descriptor, 1)
        os.dup2(descriptor, 2)
        os.close(descriptor)


def cut(path: str, max_bytes: int = MAX_BYTES) -> None:
    """Cut a file that has grown too long: its second half goes to ``.1``, the file is emptied."""
    with contextlib.suppress(OSError):
        size = os.stat(path, follow_symlinks=False).st_size
        if size <= max_bytes:
            return
        with open(path, "r+b") as file:
            file.seek(-(max_bytes // 2), os.SEEK_END)
            kept = file.read()
            file.truncate(0)
        with open(os.open(f"{path}.1", os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as old:
            old.write(kept)
