"""Redirects descriptors 1 and 2 of a process to a file: C code, programs, crashes.

It goes to a file of plain text for each process, ``.out`` beside its log: a pipe would hold a
process up whose reader is gone, or busy. A process begins its file anew and keeps the one before
it as ``.out.1``. Files that grow are cut by the manager, now and then.
"""

from __future__ import annotations

import contextlib
import os
import re
import time

from rtkit.link import places
from rtkit.logs.logfile import MAX_BYTES, open_private
from rtkit.rtc.create import FRESH_SLAVE

KEPT = 32
"""How many dead slaves that were named after their process keep their logs."""


def redirect(path: str, name: str) -> None:
    """Have descriptors 1 and 2 of this process lead to its own file; on failure they stay."""
    with contextlib.suppress(OSError):
        if os.stat(path, follow_symlinks=False).st_size:
            os.replace(path, f"{path}.1")
    with contextlib.suppress(OSError):
        descriptor = open_private(path)
        os.dup2(descriptor, 1)
        os.dup2(descriptor, 2)
        os.close(descriptor)
        os.write(1, head(name, os.getpid()))


def head(name: str, pid: int) -> bytes:
    """Return the line with which the output of a process begins."""
    moment = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    return f"== {name}, pid {pid}, {moment}\n".encode("utf-8", "replace")


def is_of(text: str, pid: int) -> bool:
    """Return whether this is the output of that process."""
    return re.match(rf"== .*, pid {pid}, [^,\n]*\n", text) is not None


def cut(path: str, max_bytes: int = MAX_BYTES) -> None:
    """Cut a file that has grown too long: its end goes to ``.1``, it begins anew with its head."""
    with contextlib.suppress(OSError):
        if os.stat(path, follow_symlinks=False).st_size <= max_bytes:
            return
        with open(path, "r+b") as file:
            begin = file.readline(1024)
            file.seek(-(max_bytes // 2), os.SEEK_END)
            kept = file.read()
            file.truncate(0)
            os.pwrite(file.fileno(), begin, 0)  # a process that writes meanwhile appends
        with open(os.open(f"{path}.1", os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as old:
            old.write(kept)


def forget_old(manager: str, kept: int = KEPT) -> None:
    """Remove logs of dead slaves that no later one continues, but for the newest few."""
    slave = re.escape(FRESH_SLAVE).replace("%p", r"(\d+)")
    pattern = re.compile(rf"{re.escape(manager)}\.{slave}\.(log|out)(\.\d+)?")
    found: dict[int, list[os.DirEntry[str]]] = {}
    with contextlib.suppress(OSError), os.scandir(places.state_dir()) as entries:
        for entry in entries:
            match = pattern.fullmatch(entry.name)
            if match is not None and not os.path.exists(f"/proc/{match[1]}"):
                found.setdefault(int(match[1]), []).append(entry)
        newest = sorted(found.values(), key=_newest, reverse=True)
        for entry in (each for files in newest[kept:] for each in files):
            os.unlink(entry.path)


def _newest(files: list[os.DirEntry[str]]) -> float:
    return max(each.stat(follow_symlinks=False).st_mtime for each in files)
