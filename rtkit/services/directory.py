"""Files below one directory, reached by its handle alone: no path or link leads out of it.

Every step is opened by its name in the directory before it, without following links; so what is
swapped meanwhile is met as what it is, or not at all. A file is written under another name first
and takes its own when it is whole. No error has a path in it.

Source: `property-service` reference, section 11.
"""

from __future__ import annotations

import errno
import fcntl
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from secrets import token_hex
from time import monotonic, time_ns
from typing import NamedTuple

from rtkit import PropertyError
from rtkit.services.paths import DEEPEST, TEMPORARY, Path, is_allowed

_STEP = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
_FILE = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
_NEW = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
_TICK_NS = 30_000_000
"""A file that changes within this time of a look may bear its time of before [ns]."""
_CODES = {
    errno.ENOENT: ("unknown", "there is no such file"),
    errno.ENOTDIR: ("unknown", "there is no such file"),
    errno.ELOOP: ("unknown", "there is no such file"),
    errno.EACCES: ("denied", "the file may not be used"),
    errno.EPERM: ("denied", "the file may not be used"),
    errno.EROFS: ("denied", "files here are only read"),
    errno.EEXIST: ("conflict", "there is one of that name"),
    errno.EISDIR: ("conflict", "that is a directory"),
    errno.ENOTEMPTY: ("conflict", "the directory is not empty"),
    errno.ENAMETOOLONG: ("denied", "the name is too long"),
    errno.ENOSPC: ("too-large", "there is no room left"),
    errno.EDQUOT: ("too-large", "there is no room left"),
    errno.EFBIG: ("too-large", "there is no room left"),
}


@contextmanager
def _without_paths() -> Iterator[None]:
    """Turn a refusal of the system into one that has no path in it."""
    try:
        yield
    except OSError as error:
        code, text = _CODES.get(error.errno or 0, ("internal", os.strerror(error.errno or 0)))
        raise PropertyError(code, text) from None


class Folder(NamedTuple):
    """Content of a directory, as it was found.

    Attributes:
        mark: Differs when a name comes or goes.
        folders: Names of directories in it.
        files: Names of files in it.
        left_out: How many others are in it.
    """

    mark: tuple[int, int]
    folders: tuple[str, ...]
    files: tuple[str, ...]
    left_out: int

    @property
    def held(self) -> tuple[object, ...]:
        """Return all but the mark."""
        return self[1:]


class Upload:
    """File that is not whole yet, under another name; locked, so that nobody takes it for left.

    Attributes:
        path: Of the file that it is to be.
        whole: How much it is to hold [bytes].
        size: How much it holds [bytes].
        touched: When something was written last.
    """

    def __init__(self, parent: int, path: Path, whole: int, *, is_synced: bool) -> None:
        self._parent = os.dup(parent)
        self._name = f"{TEMPORARY}{token_hex(8)}"
        self._is_synced = is_synced
        self.path, self.whole, self.size, self.touched = path, whole, 0, monotonic()
        try:
            self._file = os.open(self._name, _NEW, 0o666, dir_fd=self._parent)
        except OSError:
            os.close(self._parent)
            raise
        fcntl.flock(self._file, fcntl.LOCK_EX)

    def write(self, data: bytes, offset: int) -> None:
        """Write a block at its place."""
        view = memoryview(data)
        with _without_paths():
            while view:
                done = os.pwrite(self._file, view, offset)
                view, offset = view[done:], offset + done
        self.size, self.touched = max(self.size, offset), monotonic()

    def digest(self) -> str:
        """Return the SHA-256 of what was written."""
        with _without_paths():
            os.lseek(self._file, 0, os.SEEK_SET)
            return _digest(self._file)

    def commit(self, name: str) -> None:
        """Have the file take its name, at once and for good.

        Raises:
            PropertyError: ``conflict``: what bears that name is no file.
        """
        with _without_paths():
            _check_replaceable(name, self._parent)
            if self._is_synced:
                os.fsync(self._file)
            os.rename(self._name, name, src_dir_fd=self._parent, dst_dir_fd=self._parent)
            self._name = ""
            if self._is_synced:
                os.fsync(self._parent)

    def close(self) -> None:
        """Leave nothing of it that was not committed."""
        with suppress(OSError):  # somebody else has removed it
            if self._name:
                os.unlink(self._name, dir_fd=self._parent)
        os.close(self._file)
        os.close(self._parent)


class Directory:
    """One directory with all below it.

    Args:
        root: Its path; it is followed once, and where it leads to is kept.
        hidden: Names that begin with a dot are allowed.
        is_synced: Written data are on the disk before they count.

    Raises:
        PropertyError: ``unknown``, ``denied``: it cannot be opened.
    """

    def __init__(self, root: str, *, hidden: bool = False, is_synced: bool = True) -> None:
        self._hidden = hidden
        self._is_synced = is_synced
        with _without_paths():
            self._root = os.open(root, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)

    def close(self) -> None:
        """Let go of it."""
        os.close(self._root)

    @contextmanager
    def _within(self, parents: Path) -> Iterator[int]:
        """Open the directory at a path, step by step."""
        with _without_paths():
            here = os.open(".", _STEP, dir_fd=self._root)
            try:
                for part in parents:
                    below = os.open(part, _STEP, dir_fd=here)
                    os.close(here)
                    here = below
                yield here
            finally:
                os.close(here)

    @contextmanager
    def _opened(self, path: Path) -> Iterator[int]:
        with self._within(path[:-1]) as parent:
            _check_file(os.stat(path[-1], dir_fd=parent, follow_symlinks=False))
            file = os.open(path[-1], _FILE, dir_fd=parent)
            try:
                _check_file(os.fstat(file))
                yield file
            finally:
                os.close(file)

    def read(self, path: Path, offset: int, length: int) -> bytes:
        """Return a part of a file; less than `length` bytes only at its end."""
        with self._opened(path) as file:
            parts = []
            while length > 0 and (part := os.pread(file, length, offset)):
                parts.append(part)
                offset, length = offset + len(part), length - len(part)
            return b"".join(parts)

    def digest(self, path: Path) -> str:
        """Return the SHA-256 of a file."""
        with self._opened(path) as file:
            return _digest(file)

    def contains(self, path: Path, text: bytes) -> bool:
        """Return whether a text is in a file."""
        rest = b""
        with self._opened(path) as file:
            while part := os.read(file, 1 << 20):
                if text in rest + part:
                    return True
                rest = part[-len(text) :]
        return False

    def status(self, path: Path) -> os.stat_result:
        """Return size and times of a file."""
        with self._within(path[:-1]) as parent:
            found = os.stat(path[-1], dir_fd=parent, follow_symlinks=False)
            _check_file(found)
            return found

    def upload(self, path: Path, whole: int) -> Upload:
        """Begin a file that takes its place when it is whole."""
        with self._within(path[:-1]) as parent:
            _check_replaceable(path[-1], parent)
            return Upload(parent, path, whole, is_synced=self._is_synced)

    def remove(self, path: Path) -> None:
        """Remove a file, or a directory that is empty."""
        with self._within(path[:-1]) as parent:
            mode = os.stat(path[-1], dir_fd=parent, follow_symlinks=False).st_mode
            if stat.S_ISDIR(mode):
                os.rmdir(path[-1], dir_fd=parent)
            elif stat.S_ISREG(mode):
                os.unlink(path[-1], dir_fd=parent)
            else:
                raise FileNotFoundError(errno.ENOENT, "")

    def make(self, path: Path) -> None:
        """Make a directory."""
        with self._within(path[:-1]) as parent:
            os.mkdir(path[-1], dir_fd=parent)

    def mark(self, path: Path) -> tuple[int, int] | None:
        """Return what differs when a name in a directory came or went; None of what is gone."""
        try:
            found = os.stat("/".join(path) or ".", dir_fd=self._root, follow_symlinks=False)
        except OSError:
            return None
        return found.st_ino, found.st_mtime_ns

    def look(self, path: Path) -> Folder:
        """Return what a directory holds; remove what uploads have left there that ended."""
        folders, files, others = [], [], 0
        with self._within(path) as here:
            found = os.fstat(here)
            is_settled = time_ns() - found.st_mtime_ns > _TICK_NS
            with os.scandir(here) as entries:
                for entry in entries:
                    if entry.name.startswith(TEMPORARY):
                        is_settled = _clear(entry.name, here) and is_settled
                    elif not is_allowed(entry.name, hidden=self._hidden):
                        others += not entry.name.startswith(".")
                    elif entry.is_dir(follow_symlinks=False) and len(path) < DEEPEST:
                        folders.append(entry.name)
                    elif entry.is_file(follow_symlinks=False):
                        files.append(entry.name)
                    else:
                        others += 1
        mark = (found.st_ino, found.st_mtime_ns if is_settled else 0)
        return Folder(mark, tuple(sorted(folders)), tuple(sorted(files)), others)


def _check_file(found: os.stat_result) -> None:
    """Refuse what is no file: a link, a pipe, a device."""
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, "")
    if not stat.S_ISREG(found.st_mode):
        raise FileNotFoundError(errno.ENOENT, "")


def _check_replaceable(name: str, parent: int) -> None:
    with suppress(FileNotFoundError):
        if not stat.S_ISREG(os.stat(name, dir_fd=parent, follow_symlinks=False).st_mode):
            raise FileExistsError(errno.EEXIST, "")


def _digest(file: int) -> str:
    summed = sha256()
    while part := os.read(file, 1 << 20):
        summed.update(part)
    return summed.hexdigest()


def _clear(name: str, parent: int) -> bool:
    """Remove a file whose upload has ended; return False if it is too new to be sure of that."""
    with suppress(OSError):  # it is locked: somebody writes it
        file = os.open(name, _FILE, dir_fd=parent)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if time_ns() - os.fstat(file).st_mtime_ns < 1_000_000_000:
                return False
            os.unlink(name, dir_fd=parent)
        finally:
            os.close(file)
    return True
