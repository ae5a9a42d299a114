"""Store of desired state: one table of rows, each change synced to disk before it counts.

SQLite with a write-ahead log that is synced at each commit: a kill or a loss of power at any moment
leaves the rows before a commit or those after it. A store that cannot be read is kept aside, never
deleted.

How many commits there were is noted in a file beside it, too: so it is seen when the store, or some
of its journal, is gone.

See decision 25.
"""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
import sqlite3
import struct
import tempfile
from collections.abc import Iterable
from contextlib import closing, suppress
from typing import NamedTuple

from rtkit import fault
from rtkit.errors import Refused
from rtkit.link import places

Row = tuple[str, str, str | None]
"""Kind, name and value; without a value the row goes."""

APPLICATION = 0x72746B77
VERSION = 1
NOTED = "-commits"
_BESIDE = ("-wal", "-shm", "-journal", NOTED)
"""Endings of the files beside a store that bear its name."""
_DIGITS = 20
_BUSY_S = 1.0
_LOCKS, _LOCKS_LENGTH = 0x40000000, 512
"""Where in its file SQLite has its locks."""
_ASIDE = 99
_BUSY = (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED)
_DAMAGED = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_ERROR)
_TABLE = """
create table kept (
    seq integer primary key,
    kind text not null,
    name text not null,
    value text not null,
    unique (kind, name)
)
"""
_COMMITS = "create table if not exists commits (number integer not null)"
_PUT = """
insert into kept (kind, name, value) values (?, ?, ?)
on conflict (kind, name) do update set value = excluded.value
"""


def take_over_former_name(path: str) -> None:
    """Rename a store that lies under its former name, and the files beside it.

    The store itself comes last: broken off anywhere, the next call goes on.

    Raises:
        OSError: It cannot be renamed.
    """
    former = places.former_store_file(path)
    if os.path.lexists(path) or not os.path.lexists(former):
        return
    for beside in (*_BESIDE, ""):
        with suppress(FileNotFoundError):
            os.rename(f"{former}{beside}", f"{path}{beside}")


class StoreFailed(Exception):
    """Nothing was written; the text gives the reason and the file."""


class StoreLost(StoreFailed):
    """The file was removed or replaced since it was written: its rows must be stored again."""


class _Damaged(Exception):
    """The file is no store, or not a whole one."""


class _Linked(OSError):
    """A file of the store is a link: whoever made it chose its target."""


class StoredRows(NamedTuple):
    """Rows of a store at its opening, and a finding about it."""

    rows: list[Row]
    finding: str = ""


class Store:
    """Store at a path; it is made when the first row is written, or by `prepare`.

    Only one thread may use it at a time.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self._db: sqlite3.Connection | None = None
        self._file: tuple[int, int] | None = None
        self._commits = 0
        self._noted = Noted(path)

    def find(self) -> StoredRows:
        """Return the rows that are there.

        Raises:
            Refused: Another process uses the file, a newer rtkit has written it, or it is a link.
        """
        try:
            take_over_former_name(self._path)
        except OSError as error:
            why = f"{places.former_store_file(self._path)}: {error.strerror}"
            return StoredRows([], f"the state store cannot be renamed ({why})")
        try:
            rows = self._open()
            return StoredRows(rows, self._lacking())
        except _Linked as error:
            cure = "remove it, or name the folder that is meant with RTKIT_STATE_DIR"
            raise Refused(f"{error.filename} is a link, and not written through: {cure}") from error
        except _Damaged as error:
            return StoredRows([], f"{self.set_aside('damaged')} ({error})")
        except sqlite3.OperationalError as error:
            if _code(error) in _BUSY:
                whose = holder_of(self._path) or "another process"
                cure = "stop that, or give this manager a RTKIT_STATE_DIR of its own"
                why = f"{whose} uses the state store, {self._path}; {cure}"
                raise Refused(why) from error
            return self._find_in_copy(error)

    def _lacking(self) -> str:
        """Return a finding when there were more commits than are there; mostly nothing."""
        noted = self._noted.read()
        if noted <= self._commits:
            return ""
        if self._db is None:
            return f"the state store was removed ({self._path}): only what lives is known"
        lost = noted - self._commits
        why = "its journal was damaged, or an older file put in its place"
        return f"the state store lacks its last {lost} changes ({self._path}): {why}"

    def prepare(self) -> None:
        """Have a store to write to.

        Raises:
            StoreFailed: It cannot be made.
        """
        try:
            self._connected()
        except (OSError, sqlite3.Error, _Damaged) as error:
            raise StoreFailed(self._failure(error)) from error

    def write(self, rows: Iterable[Row]) -> None:
        """Write rows, all or none; they are on the disk when this returns.

        Raises:
            StoreFailed: They are not.
            StoreLost: Nor is anything that was written before; the next rows go to a new file.
        """
        try:
            db = self._connected()
            fault.point("manager.recording")
            db.execute("begin immediate")
            try:
                for kind, name, value in rows:
                    if value is None:
                        db.execute("delete from kept where kind = ? and name = ?", (kind, name))
                    else:
                        db.execute(_PUT, (kind, name, value))
                db.execute(_COMMITS)  # a store of an earlier rtkit has none
                db.execute("delete from commits")
                db.execute("insert into commits values (?)", (self._commits + 1,))
                db.execute("commit")
            except BaseException:
                with suppress(sqlite3.Error):  # it has rolled back by itself
                    db.execute("rollback")
                raise
            self._commits += 1
            self._noted.write(self._commits)
            fault.point("manager.recorded")
        except (OSError, sqlite3.Error, _Damaged) as error:
            self.close()
            raise StoreFailed(self._failure(error)) from error

    def forget(self) -> None:
        """Remove the store with all its rows: nothing is desired any more."""
        if self._db is not None:
            with suppress(sqlite3.Error):  # a table that cannot be emptied is removed
                self._db.execute("delete from kept")
        self.close()
        remove(self._path)

    def close(self) -> None:
        """Let go of the file; it is opened again when it is used again."""
        self._noted.close()
        db, self._db = self._db, None
        if db is not None:
            with suppress(sqlite3.Error):  # all that was acknowledged is in its log
                db.close()

    def _failure(self, error: BaseException) -> str:
        why = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        return f"{why} ({self._path})"

    def _connected(self) -> sqlite3.Connection:
        if self._file is not None and self._file != _identity(self._path):
            self._file = None
            self.close()
            raise StoreLost(self._lost())
        if self._db is None and not os.path.lexists(self._path):
            self._make()
        if self._db is None:
            self._open()
        assert self._db is not None
        self._noted.open()  # now: no commit may be refused that is done
        return self._db

    def _lost(self) -> str:
        """Make way for a new file; return a finding about the one that there was."""
        if os.path.lexists(self._path):
            return f"the state store was replaced by another file; {self.set_aside('foreign')}"
        return f"the state store was removed ({self._path})"

    def _make(self) -> None:
        """Make an empty store, whole or not at all: under another name first."""
        draft = f"{self._path}.new"
        remove(draft)
        db = sqlite3.connect(draft, isolation_level=None)
        try:
            db.execute("pragma synchronous = off")  # it is synced once, at the end
            db.execute(f"pragma application_id = {APPLICATION}")
            db.execute(f"pragma user_version = {VERSION}")
            db.execute(_TABLE)
            db.execute("pragma journal_mode = wal")
        finally:
            db.close()
        os.chmod(draft, 0o600)
        _sync(draft, os.O_RDWR)
        remove(self._path)  # a log without its file would be taken for one of the new file
        os.rename(draft, self._path)
        _sync(os.path.dirname(self._path), os.O_RDONLY)

    def _open(self) -> list[Row]:
        _check_no_links(self._path)
        self._commits = 0
        if not os.path.lexists(self._path):
            return []
        db = sqlite3.connect(
            self._path, timeout=_BUSY_S, isolation_level=None, check_same_thread=False
        )
        try:
            rows, self._commits = _read(db, self._path)
        except BaseException:
            db.close()
            raise
        self._db, self._file = db, _identity(self._path)
        return rows

    def set_aside(self, what: str) -> str:
        """Give a file that is not to be used another name, with what it is; return a finding."""
        for number in range(1, _ASIDE + 1):
            aside = f"{self._path}.{what}-{number}"
            if number == _ASIDE or not os.path.lexists(aside):
                break
        try:
            take_over_former_name(self._path)
            os.rename(self._path, aside)
            for suffix in ("-wal", "-shm", NOTED):
                with suppress(FileNotFoundError):
                    os.rename(self._path + suffix, aside + suffix)
        except OSError as error:
            return f"the {what} state store stays: {self._failure(error)}"
        return f"the {what} state store is kept aside: {aside}"

    def _find_in_copy(self, why: sqlite3.Error) -> StoredRows:
        """Read what cannot be written, or not where it is."""
        finding = f"the state store cannot be written: {self._failure(why)}"
        try:
            return StoredRows(_read_copy(self._path), finding)
        except (OSError, sqlite3.Error, _Damaged) as error:
            return StoredRows([], f"{finding}, nor read: {error}")


def rows_of_copy(path: str) -> list[Row]:
    """Return the rows of a store that nobody uses, and leave it as it is; none if it is damaged."""
    try:
        return _read_copy(path)
    except (OSError, sqlite3.Error, _Damaged, Refused):
        return []


def _read_copy(path: str) -> list[Row]:
    with tempfile.TemporaryDirectory(dir=places.runtime_dir()) as folder:
        copy = os.path.join(folder, "copy")
        for suffix in ("", "-wal"):
            if not suffix or os.path.exists(path + suffix):
                shutil.copyfile(path + suffix, copy + suffix)
        with closing(sqlite3.connect(copy, isolation_level=None)) as db:
            return _read(db, path)[0]


class Noted:
    """The number of commits that a store has acknowledged, in a file beside it.

    It is not synced: a loss of power may leave an older number, a kill does not.
    """

    def __init__(self, path: str) -> None:
        self._path = path + NOTED
        self._descriptor = -1

    def read(self) -> int:
        """Return the number; 0 where none can be read."""
        try:
            with open(self._path, "rb") as file:
                return int(file.read(_DIGITS))
        except (OSError, ValueError):
            return 0

    def open(self) -> None:
        """Be ready to write.

        Raises:
            OSError: It cannot be made.
        """
        if self._descriptor < 0:
            flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
            self._descriptor = os.open(self._path, flags, 0o600)
            if not os.fstat(self._descriptor).st_size:
                self.write(0)  # so that there is room for all others

    def write(self, number: int) -> None:
        """Note a number."""
        os.pwrite(self._descriptor, b"%0*d\n" % (_DIGITS, number), 0)

    def close(self) -> None:
        """Let go of the file."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def _check_no_links(path: str) -> None:
    """Refuse links where the files of a store should be.

    Raises:
        _Linked: One is there.
    """
    for suffix in ("", *_BESIDE):
        if os.path.islink(path + suffix):
            raise _Linked(errno.ELOOP, os.strerror(errno.ELOOP), path + suffix)


def _read(db: sqlite3.Connection, path: str) -> tuple[list[Row], int]:
    """Return the rows of a store that is whole, and how many commits it has had.

    It is written safely from now on.

    Raises:
        Refused: A newer rtkit has written it.
    """
    try:
        db.execute("pragma locking_mode = exclusive")
        (application,) = db.execute("pragma application_id").fetchone()
        (version,) = db.execute("pragma user_version").fetchone()
        if application != APPLICATION:
            empty = " (it is empty)" if not os.path.getsize(path) else ""
            raise _Damaged(f"not a state store{empty}")
        if version > VERSION:
            reason = f"a newer rtkit wrote the state store, {path} (version {version})"
            aside = "rtmgr start -o rtkit.restore:NO puts it aside and begins empty"
            raise Refused(f"{reason}: use that one, or {aside}")
        if version != VERSION:
            raise _Damaged(f"version {version} of its form")
        (found,) = db.execute("pragma quick_check(1)").fetchone()
        if found != "ok":
            raise _Damaged(found.strip().splitlines()[-1])
        db.execute("pragma synchronous = full")
        is_counted = db.execute("select 1 from sqlite_master where name = 'commits'").fetchone()
        counted = db.execute("select number from commits").fetchone() if is_counted else None
        rows = db.execute("select kind, name, value from kept order by seq").fetchall()
        return rows, counted[0] if counted else 0
    except sqlite3.DatabaseError as error:
        if _code(error) in _DAMAGED:
            raise _Damaged(str(error)) from error
        raise


def holder_of(path: str) -> str:
    """Return which process has locked a store; empty if that cannot be known."""
    whole = struct.pack("hhqqi4x", fcntl.F_WRLCK, os.SEEK_SET, _LOCKS, _LOCKS_LENGTH, 0)
    try:
        with open(path, "rb+") as file:
            lock = fcntl.fcntl(file, fcntl.F_GETLK, whole)
        kind, _, _, _, pid = struct.unpack("hhqqi4x", lock)
        if kind == fcntl.F_UNLCK or pid <= 0:
            return ""
        with open(f"/proc/{pid}/comm", encoding="utf-8", errors="replace") as comm:
            return f"process {pid} ({comm.read().strip()})"
    except OSError:
        return ""


def _identity(path: str) -> tuple[int, int] | None:
    """Return the identity of a file among those of its name; None where there is none."""
    try:
        found = os.lstat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino


def remove(path: str) -> bool:
    """Remove a store that nobody uses; return whether there was one."""
    is_there = os.path.lexists(path)
    for suffix in ("", *_BESIDE):
        with suppress(FileNotFoundError):
            os.unlink(path + suffix)
    return is_there


def _code(error: sqlite3.Error) -> int:
    """Return the primary code of an error, 0 if it has none."""
    return int(getattr(error, "sqlite_errorcode", 0)) & 0xFF


def _sync(path: str, flags: int) -> None:
    descriptor = os.open(path, flags | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
