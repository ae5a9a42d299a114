"""Reads files that decide what code runs, and only if no stranger can have written them."""

from __future__ import annotations

import os
import stat
from typing import NamedTuple

from rtkit.errors import NotFound, Refused

_LARGEST = 16 * 1024 * 1024


class Private(NamedTuple):
    """A file that was read, and where it was when it was: all links led there."""

    data: bytes
    real: str


def read_private(path: str, *, must_be_ours: bool = False) -> bytes:
    """Return the content of a file, as `find_private` does."""
    return find_private(path, must_be_ours=must_be_ours).data


def find_private(path: str, *, must_be_ours: bool = False) -> Private:
    """Return the content of a file, and its place; the open file itself is checked.

    Args:
        path: The file; symbolic links are followed.
        must_be_ours: Nobody named it, it was found: refuse those of other users too.

    Raises:
        NotFound: There is no such file.
        Refused: It is no file, is too large, or strangers can have written it.
    """
    if "\0" in path:
        raise Refused(f"not a file: {path!r}")
    descriptor = _open(path)
    try:
        status = os.fstat(descriptor)
        real = os.readlink(f"/proc/self/fd/{descriptor}")
        _check_file(status, path)
        is_shared = check_folders(real, path)
        if (must_be_ours or is_shared) and status.st_uid not in (os.getuid(), 0):
            raise Refused(f"file belongs to another user, refused: {path}")
        return Private(os.read(descriptor, _LARGEST), real)
    except OSError as error:
        raise Refused(f"cannot read {path}: {error.strerror}") from error
    finally:
        os.close(descriptor)


def _open(path: str) -> int:
    try:
        return os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    except FileNotFoundError:
        raise NotFound(f"no such file: {path}") from None
    except OSError as error:
        raise Refused(f"cannot open {path}: {error.strerror}") from error


def _check_file(status: os.stat_result, path: str) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise Refused(f"not a file: {path}")
    if status.st_mode & stat.S_IWOTH:
        raise Refused(f"file may be written by everybody, refused: {path}")
    if status.st_size > _LARGEST:
        raise Refused(f"file is larger than {_LARGEST} bytes: {path}")


def check_folders(real: str, path: str) -> bool:
    """Refuse a file of which some folder may be written by everybody.

    A folder as ``/tmp``, in which only the owner of an entry may replace it, is none of them; but
    then owners matter, which is what is returned.

    Raises:
        Refused: Names the folder.
    """
    folders = []
    folder = os.path.dirname(real)
    while folder != "/":
        folders.append((folder, os.lstat(folder)))
        folder = os.path.dirname(folder)
    for name, status in folders:
        if status.st_mode & stat.S_IWOTH and not status.st_mode & stat.S_ISVTX:
            raise Refused(f"folder {name} may be written by everybody, refused: {path}")
    is_shared = any(status.st_mode & stat.S_IWOTH for _, status in folders)
    strangers = [name for name, status in folders if status.st_uid not in (os.getuid(), 0)]
    if is_shared and strangers:
        raise Refused(f"folder {strangers[0]} belongs to another user, refused: {path}")
    return is_shared
