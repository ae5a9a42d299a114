"""Fault points: named places where a test breaks a process off, to see what is left.

Fault points do nothing unless the environment variable ``RTKIT_FAULT`` names a folder. Then each
process notes each pass in the file ``passed`` of the folder. The file ``orders`` states the actions
at some passes: lines of ``NAME NUMBER ACTION [ARGUMENT]``, where the number counts the passes of
that name. The file ``struck`` notes the actions done. See ``docs/faults.md``.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from rtkit.errors import Refused

VARIABLE = "RTKIT_FAULT"
ALLOW_KEY = "rtkit.allow_faults"
"""Property of a manager that runs as root: it may be broken off."""

_FOLDER = os.environ.get(VARIABLE, "")
_DELAY_S = 0.3


def point(name: str) -> None:
    """Do at this place what a test has ordered for it; in ordinary life that is nothing."""
    if _FOLDER:
        _pass(name)


@contextmanager
def unheeded() -> Iterator[None]:
    """Have points do nothing: steps of the warm-up are done at no certain time."""
    global _FOLDER
    folder, _FOLDER = _FOLDER, ""
    try:
        yield
    finally:
        _FOLDER = folder


def check(is_allowed: bool) -> None:
    """Refuse to be a daemon that is broken off, if that would be against its user's interest.

    Raises:
        Refused: It is root's and nobody allowed it, or others can write the orders.
    """
    if not _FOLDER:
        return
    if os.geteuid() == 0 and not is_allowed:
        raise Refused(f"{VARIABLE} is set: a manager of root wants --allow-faults, too")
    try:
        status = os.stat(_FOLDER)
    except OSError as error:
        raise Refused(f"{VARIABLE} names no folder: {_FOLDER} ({error.strerror})") from error
    if status.st_uid != os.geteuid() or status.st_mode & 0o077:
        raise Refused(f"{VARIABLE} names a folder of others, or open to them: {_FOLDER}")


def _pass(name: str) -> None:
    import fcntl

    descriptor = _open("passed")
    try:
        # Not lockf: threads of one process are to exclude each other as well.
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        os.write(descriptor, f"{name} {os.getpid()}\n".encode())
        with open(descriptor, encoding="utf-8", closefd=False) as file:
            file.seek(0)
            number = sum(line.split()[0] == name for line in file)
        order = _order(name, number)
        if order:
            struck = _open("struck")
            os.write(struck, f"{name} {number} {os.getpid()} {order[0]}\n".encode())
            os.close(struck)
    finally:
        os.close(descriptor)
    if order:
        _strike(*order)


def _open(name: str) -> int:
    flags = os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
    return os.open(os.path.join(_FOLDER, name), flags, 0o600)


def _order(name: str, number: int) -> list[str]:
    try:
        with open(os.path.join(_FOLDER, "orders"), encoding="utf-8") as file:
            orders = [line.split() for line in file]
    except FileNotFoundError:
        return []
    return next((order[2:] for order in orders if order[:2] == [name, str(number)]), [])


def _strike(action: str, argument: str = "") -> None:
    import errno
    import signal
    import time

    if action == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    elif action == "stop":
        os.kill(os.getpid(), signal.SIGSTOP)
    elif action == "delay":
        time.sleep(float(argument or _DELAY_S))
    elif action == "raise":
        number = getattr(errno, argument or "EIO")
        raise OSError(number, os.strerror(number))
    else:
        raise ValueError(f"unknown action: {action}")
