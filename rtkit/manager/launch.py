"""Starts a manager of this host: as a daemon, or in the foreground."""

from __future__ import annotations

import os
import select
import signal
import sys
import time

from rtkit.errors import Refused, Unreachable
from rtkit.link import places

_LONGEST_S = 86_400.0
_LOG_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_APPEND


def start(name: str, timeout_s: float) -> int:
    """Start a manager as a daemon and return its pid when it answers.

    Raises:
        Refused: It runs already, or cannot start; says why.
        Unreachable: It did not get ready in time, and was ended.
    """
    places.make_private(places.state_dir())
    ready_read, ready_write = os.pipe()
    os.set_inheritable(ready_write, True)
    arguments = [sys.executable, "-m", "rtkit.manager.daemon", name, str(ready_write)]
    pid = _spawn(arguments, places.log_file(name))
    os.close(ready_write)
    try:
        text = _first_line(ready_read, timeout_s)
    finally:
        os.close(ready_read)
    if text == "ready":
        return pid
    if text is None:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        raise Unreachable(f"manager {name!r} was not ready within {timeout_s:g} s and was ended")
    os.waitpid(pid, 0)
    raise Refused(text or f"manager {name!r} ended at once, see {places.log_file(name)}")


def run(name: str) -> int:
    """Be the manager in the foreground; return the exit status."""
    import logging

    from rtkit.manager.daemon import run as run_daemon

    logging.basicConfig(stream=sys.stderr, level=logging.INFO, format="%(message)s")
    return run_daemon(name)


def _spawn(arguments: list[str], log: str) -> int:
    actions = [
        (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0),
        (os.POSIX_SPAWN_OPEN, 1, log, _LOG_FLAGS, 0o600),
        (os.POSIX_SPAWN_DUP2, 1, 2),
    ]
    try:
        return os.posix_spawn(
            arguments[0], arguments, os.environ, file_actions=actions, setsid=True
        )
    except OSError as error:
        raise Refused(f"cannot start a manager: {error}") from error


def _first_line(descriptor: int, timeout_s: float) -> str | None:
    """Return what is told within `timeout_s`, "" for nothing at all, None when time is up."""
    deadline = time.monotonic() + min(timeout_s, _LONGEST_S)
    text = b""
    while not text.endswith(b"\n"):
        if not select.select([descriptor], [], [], max(0.0, deadline - time.monotonic()))[0]:
            return None
        chunk = os.read(descriptor, 4096)
        if not chunk:
            break
        text += chunk
    return text.decode("utf-8", "replace").strip()
