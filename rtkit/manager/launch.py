"""Starts a manager of this host: as a daemon, or in the foreground."""

from __future__ import annotations

import fcntl
import os
import select
import signal
import sys
import time
from typing import NamedTuple

from rtkit import fault
from rtkit.errors import Partial, Refused, Unreachable
from rtkit.link import places
from rtkit.manager.child_process import unmarked, withhold
from rtkit.manager.report import ERROR, FAILURE, READY, READY_VARIABLE, WANTED_VARIABLE, WARNING
from rtkit.settings.configuration import CommandLineSettings

_LONGEST_S = 86_400.0
_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW


class Started(NamedTuple):
    """A manager that answers, and its report of its start."""

    pid: int
    warnings: tuple[str, ...]
    failures: tuple[str, ...]


def start(name: str, wanted: CommandLineSettings, timeout_s: float) -> Started:
    """Start a manager as a daemon and return when it answers.

    Raises:
        Refused: It runs already, or cannot start; gives the reason.
        Partial: So, and these things that it was to do at start failed.
        Unreachable: It did not get ready in time, and was ended.
    """
    places.make_private(places.state_dir())
    ready_read, ready_write = os.pipe()
    withhold()
    os.set_inheritable(ready_write, True)
    # -P: no file of this folder stands in for a standard module.
    arguments = [sys.executable, "-P", "-m", "rtkit.manager.daemon", name]
    environment = {
        **unmarked(os.environ),
        READY_VARIABLE: str(ready_write),
        WANTED_VARIABLE: wanted.to_text(),  # there may be secrets in it, and others see arguments
    }
    pid = _spawn(arguments, environment, places.output_file(name))
    os.close(ready_write)
    fault.point("start.spawned")
    try:
        lines = receive_lines(ready_read, timeout_s)
    finally:
        os.close(ready_read)
    if lines is None:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        raise Unreachable(f"manager {name!r} was not ready within {timeout_s:g} s and was ended")
    if lines[-1:] != [READY]:
        os.waitpid(pid, 0)
    fault.point("start.told")
    return read_report(name, pid, lines)


def ensure(name: str, wanted: CommandLineSettings, timeout_s: float) -> None:
    """Start a manager unless it runs; another process may ask for that at the same time.

    Raises:
        Refused: It cannot start; gives the reason.
        Unreachable: It did not get ready in time, and was ended.
    """
    folder = os.open(places.make_private(places.state_dir()), os.O_RDONLY)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX)  # whoever starts it has it until it is ready
        if places.owner(name) is None:
            start(name, wanted, timeout_s)
    finally:
        os.close(folder)


def read_report(name: str, pid: int, lines: list[str]) -> Started:
    """Return the report of a manager about its start.

    Raises:
        Refused: There is none; gives the reason.
        Partial: There is none, because of these failures.
    """
    kinds: dict[str, list[str]] = {WARNING: [], FAILURE: [], ERROR: []}
    for line in lines:
        for kind, texts in kinds.items():
            if line.startswith(kind):
                texts.append(line.removeprefix(kind))
    if lines[-1:] == [READY]:
        return Started(pid, tuple(kinds[WARNING]), tuple(kinds[FAILURE]))
    why = " ".join(kinds[ERROR])
    why = why or f"manager {name!r} ended at once{_last_line(places.output_file(name))}"
    if kinds[FAILURE]:
        raise Partial(why, [(text, Refused(text)) for text in kinds[FAILURE]])
    raise Refused(why)


def run(name: str, wanted: CommandLineSettings) -> int:
    """Be the manager in the foreground; return the exit status."""
    if os.getpid() == 1:  # of a container: the kernel ignores what it has no handler for
        signal.signal(signal.SIGTERM, lambda number, _frame: sys.exit(128 + number))
    from rtkit.manager.daemon import run as run_daemon

    return run_daemon(name, wanted, is_shown=True)


def receive_lines(descriptor: int, timeout_s: float) -> list[str] | None:
    """Return the lines received until the manager is ready or ends, None when time is up."""
    deadline = time.monotonic() + min(timeout_s, _LONGEST_S)
    text = b""
    while not text.endswith(b"\n" + READY.encode() + b"\n") and text != READY.encode() + b"\n":
        if not select.select([descriptor], [], [], max(0.0, deadline - time.monotonic()))[0]:
            return None
        chunk = os.read(descriptor, 4096)
        if not chunk:
            break
        text += chunk
    return text.decode("utf-8", "replace").splitlines()


def _last_line(path: str) -> str:
    """Return the last thing that a manager wrote past its log, in brackets, and where more is."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            lines = [line.strip() for line in file if line.strip() and not line.startswith("== ")]
    except OSError:
        lines = []
    return f" ({lines[-1]}), see {path}" if lines else ""


def _spawn(arguments: list[str], environment: dict[str, str], output: str) -> int:
    """Start a process whose output goes to the end of a file, or nowhere if the disk is full."""
    try:
        descriptor = os.open(output, _FLAGS, 0o600)
    except OSError:
        descriptor = os.open(os.devnull, os.O_WRONLY)
    actions = [
        (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0),
        (os.POSIX_SPAWN_DUP2, descriptor, 1),
        (os.POSIX_SPAWN_DUP2, descriptor, 2),
    ]
    try:
        return os.posix_spawn(
            arguments[0], arguments, environment, file_actions=actions, setsid=True
        )
    except OSError as error:
        raise Refused(f"cannot start a manager: {error}") from error
    finally:
        os.close(descriptor)
