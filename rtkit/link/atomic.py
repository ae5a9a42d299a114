"""Writes files atomically: the whole new content or none of it."""

from __future__ import annotations

import errno
import os
import sys
from contextlib import suppress
from threading import get_native_id
from typing import BinaryIO

from rtkit import fault
from rtkit.errors import NotFound, Refused

STDOUT = "-"
_DRAFT = ".draft"
_LONGEST = 180
"""Part of a name that its draft bears [bytes]: a name may have 255."""


def write_output(
    data: bytes,
    output: str,
    *,
    is_new: bool = False,
    mode: int | None = None,
    is_lasting: bool = True,
) -> None:
    """Write to a file, or to stdout for ``-``.

    A file that was there is replaced in one step and keeps its mode; a link stays a link. If it
    must be new, what is there is never touched. A new file may be given a mode of its own. One that
    need not be `is_lasting` may be lost, or empty, after a power cut: the disk is not waited for.

    Raises:
        NotFound: It cannot be written; an earlier file is unchanged.
        Refused: It must be new and is not.
    """
    if output == STDOUT:
        sys.stdout.buffer.write(data)
        return
    try:
        place = os.path.realpath(output)
        if os.path.exists(place) and not os.path.isfile(place):
            # A pipe or a terminal cannot be replaced; a folder says so itself.
            with open(place, "wb") as stream:
                stream.write(data)
        else:
            mode = _mode(place) if mode is None else mode
            _replace(data, place, mode, is_new=is_new, is_lasting=is_lasting)
    except FileExistsError as error:
        raise Refused(f"{output} is there already; --force replaces it") from error
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else str(error)
        raise NotFound(f"cannot write {output}: {why}") from error


def _replace(data: bytes, place: str, mode: int, *, is_new: bool, is_lasting: bool) -> None:
    """Write a draft beside the target, and move it there.

    The draft has no name where the file system allows it, so that a kill leaves nothing behind.
    """
    if is_new and os.path.lexists(place):
        raise FileExistsError
    folder, name = os.path.split(place)
    stem = os.fsdecode(os.fsencode(name)[:_LONGEST])
    _remove_drafts(folder, stem)
    draft = os.path.join(folder, f".{stem}.{os.getpid()}.{get_native_id()}{_DRAFT}")
    try:
        target = place if is_new else draft
        if not _write_nameless(folder, data, mode, target, is_lasting=is_lasting):
            _write_named(data, mode, draft, is_lasting=is_lasting)
            target = draft
        fault.point("file.named")
        if target == draft and not (is_new and _link(draft, place)):
            os.replace(draft, place)
            fault.point("file.replaced")
    finally:
        with suppress(FileNotFoundError):
            os.unlink(draft)
    if is_lasting:
        _sync(folder)


def _write_nameless(folder: str, data: bytes, mode: int, target: str, *, is_lasting: bool) -> bool:
    """Write a file, then link it at `target`; return False where the file system cannot."""
    try:
        descriptor = os.open(folder, os.O_TMPFILE | os.O_WRONLY | os.O_CLOEXEC, 0o600)
    except OSError as error:
        if error.errno in (errno.EOPNOTSUPP, errno.EISDIR, errno.EINVAL):
            return False
        raise
    with open(descriptor, "wb") as stream:
        _write(stream, data, mode, is_lasting=is_lasting)
        # With a folder named, though the path is absolute, the link of /proc is followed.
        return _link(f"/proc/self/fd/{descriptor}", target, folder=descriptor)


def _write_named(data: bytes, mode: int, draft: str, *, is_lasting: bool) -> None:
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC
    with open(os.open(draft, flags, 0o600), "wb") as stream:
        _write(stream, data, mode, is_lasting=is_lasting)


def _write(stream: BinaryIO, data: bytes, mode: int, *, is_lasting: bool) -> None:
    stream.write(data)
    stream.flush()
    os.fchmod(stream.fileno(), mode)
    if is_lasting:
        os.fsync(stream.fileno())
    fault.point("file.written")


def _link(old: str, new: str, folder: int | None = None) -> bool:
    """Give a file a name, if nothing has that yet; return whether links can be made."""
    try:
        os.link(old, new, src_dir_fd=folder)
    except FileExistsError:
        raise
    except OSError:
        return False
    return True


def _remove_drafts(folder: str, stem: str) -> None:
    """Remove drafts left by a process that was killed between two steps."""
    for entry in os.listdir(folder):
        if entry.startswith(f".{stem}.") and entry.endswith(_DRAFT):
            pid = entry.removeprefix(f".{stem}.").partition(".")[0]
            if pid.isdigit() and not os.path.exists(f"/proc/{pid}"):
                with suppress(FileNotFoundError):
                    os.unlink(os.path.join(folder, entry))


def _sync(folder: str) -> None:
    """Make the name survive a power cut, where the file system can do that."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        with suppress(OSError):
            os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _mode(place: str) -> int:
    try:
        return os.stat(place).st_mode & 0o7777
    except FileNotFoundError:
        mask = os.umask(0)
        os.umask(mask)
        return 0o666 & ~mask
