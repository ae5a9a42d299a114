"""Claims the name of a manager by a lock, and removes stale files of earlier managers."""

from __future__ import annotations

import errno
import fcntl
import os
import stat
from collections.abc import Collection
from contextlib import ExitStack

from rtkit.errors import Refused
from rtkit.link import places, unix
from rtkit.link.processes import ProcessWatch, is_abandoned

_DYING_S = 1.0
"""How long a manager that was killed may still answer after its lock is free [s]."""

_REWRITTEN = ("held", "family", "rehearsed")
_OF_SLAVES = ("beats", "rehearsal", *_REWRITTEN, *(f"{kind}.new" for kind in _REWRITTEN))
_OF_GUESTS = "guest.beats"
_OF_ZYGOTES = ("zygote", "stage", "other")
_KINDS = (*_OF_SLAVES, _OF_GUESTS, "data", *_OF_ZYGOTES)
"""Kinds of files of a manager's processes in the runtime folder: ``<manager>.<pid>.<kind>``."""


def take_lock(name: str, stack: ExitStack) -> None:
    """Become the only manager of that name, until the stack unwinds.

    The file has the name of the host, by which commands and services of this user go, too.

    Raises:
        Refused: Another one runs; names its process.
    """
    path = places.manager_lock(name)
    if places.is_claimed(name):
        raise Refused(f"manager {name!r} is running already (pid {os.getpid()})")
    host = places.host_name()  # before there is a lock to lose
    while True:
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
        except OSError as error:
            raise Refused(f"cannot open lock file {path}: {error.strerror}") from error
        try:
            fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(descriptor)
            if error.errno not in (errno.EACCES, errno.EAGAIN):
                raise Refused(f"cannot lock {path}: {error.strerror}") from error
            owner = places.owner(name)
            if owner is None:
                continue  # it has ended meanwhile
            raise Refused(f"manager {name!r} is running already (pid {owner})") from None
        if _is_same_file(descriptor, path):
            break
        os.close(descriptor)  # its owner removed it while we waited: another one lies there now
    places.claim(name, is_held=True)
    stack.callback(places.claim, name, is_held=False)
    stack.callback(os.close, descriptor)
    stack.callback(_remove, descriptor, path)
    try:
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, host.encode(), 0)
    except OSError as error:
        raise Refused(f"cannot write {path}: {error.strerror}") from error


def _is_same_file(descriptor: int, path: str) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path, follow_symlinks=False))
    except FileNotFoundError:
        return False


def _remove(descriptor: int, path: str) -> None:
    if _is_same_file(descriptor, path):
        os.unlink(path)


def check_silence(name: str) -> None:
    """Check that no manager of that name listens, one whose lock file somebody removed.

    Raises:
        Refused: One does; names its process.
    """
    try:
        with unix.connect(places.control_socket(name)) as probe:
            pid = unix.pid_of(probe)
        process = ProcessWatch(pid)
    except OSError:
        return
    with process:
        if not process.await_end(_DYING_S):
            raise Refused(f"manager {name!r} is running already (pid {pid}), its lock was removed")


def remove_stale(name: str, living: Collection[int]) -> None:
    """Remove what a killed manager of that name and its dead slaves left.

    Args:
        name: Of the manager.
        living: Its slaves that run (see `rtkit.manager.predecessor.unreported`).

    Raises:
        Refused: Something else than a socket lies there, or it cannot be removed.
    """
    folder = places.runtime_dir()
    own = places.sockets_of(name)
    left = [os.path.join(folder, entry) for entry in os.listdir(folder)]
    for path in left:
        beside = path.removesuffix(".lock")
        is_own = beside in own
        if not is_own and not _is_of_the_dead(beside, name, living):
            continue
        try:
            if is_own and beside == path and not stat.S_ISSOCK(os.lstat(path).st_mode):
                raise Refused(f"not a socket, remove it yourself: {path}")
            os.unlink(path)
        except FileNotFoundError:
            continue  # its owner has removed it meanwhile
        except OSError as error:
            raise Refused(f"cannot remove {path}: {error.strerror}") from error


def _is_of_the_dead(path: str, name: str, living: Collection[int]) -> bool:
    """Return whether a process of that manager, and of none with a longer name, left it behind.

    Slaves outlive their manager: what belongs to one that lives is let be. Attached
    processes and zygotes are known by their sockets.
    """
    entry = os.path.basename(path)
    pid, _, kind = entry.removeprefix(f"{name}.").partition(".")
    is_one = entry == f"{name}.{pid}.{kind}" and pid.isdigit() and kind in _KINDS
    if not is_one or int(pid) in living:
        return False
    if kind == _OF_GUESTS:
        return not os.path.exists(f"/proc/{pid}")
    return kind in _OF_SLAVES or is_abandoned(path, int(pid))
