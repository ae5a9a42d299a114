"""Realms of tests: a manager in folders of its own, which ends with the test or its process."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rtkit.api.tree import Tree

_TIMEOUT_S = 20.0
_MANAGER = "manager"
_LOOKS = 5
"""How often at most is looked again while processes are found that have to be ended."""


@contextmanager
def own_manager(*folders: str | Path) -> Iterator[Tree]:
    """Start a manager in temporary folders; end it, and all that it created, on exit.

    The manager looks for modules in `folders`. `rtkit.connect` and commands that the test runs
    reach it until then. If the process of the test is killed, the manager ends by itself. What
    lives there, and what was logged, is noted at an exception that leaves the block. ::

        with own_manager(Path(__file__).parent) as tree:
            tree.create("Scale?manager_name=other")

    Raises:
        Refused: It cannot be started.
    """
    from rtkit.api.connect import connect
    from rtkit.manager.launch import start
    from rtkit.settings.configuration import CommandLineSettings

    # A socket's path may have 107 bytes, less than folders made for tests often take.
    base = Path(tempfile.mkdtemp(prefix="rtk"))
    for name in ("run", "state"):
        (base / name).mkdir(mode=0o700)
    (base / "rtc.conf").touch(mode=0o600)
    pid = 0
    with _environment(_settings(base, folders)):
        try:
            pid = start(_MANAGER, CommandLineSettings(str(base / "rtc.conf")), _TIMEOUT_S).pid
            with connect(_MANAGER, _TIMEOUT_S) as tree, _noting_failures():
                yield tree
        finally:
            try:
                _stop_managers()
            finally:
                _end_what_is_left(base)
                _reap(pid)
                shutil.rmtree(base)


def _settings(base: Path, folders: tuple[str | Path, ...]) -> dict[str, str | None]:
    """Return the environment of a realm; None for what must not reach it from outside."""
    from rtkit.container.orphans import began_at
    from rtkit.manager.child_process import ENDS_WITH

    return {
        "RTKIT_RUNTIME_DIR": str(base / "run"),
        "RTKIT_STATE_DIR": str(base / "state"),
        "RTKIT_MODULE_PATH": os.pathsep.join(str(Path(each).resolve()) for each in folders),
        "RTKIT_PORT": "none",
        "RTKIT_MANAGER": _MANAGER,
        "RTKIT_REALM": base.name,
        "RTKIT_SERVERS": "",
        # 0055: no pipe, which forks keep open, no PDEATHSIG, which a thread's end brings
        ENDS_WITH: f"{os.getpid()}:{began_at(os.getpid())}",
        **dict.fromkeys(("RTKIT_CWD", "RTCSH_CWD", "RTCTREE_NAMESERVERS")),
    }


def _stop_managers() -> None:
    """Stop the managers of the realm in order.

    Raises:
        Unreachable: One did not end in time.
    """
    from rtkit.errors import Unreachable
    from rtkit.link import places, running
    from rtkit.tree.managers import stop

    for name in running.managers():
        try:
            stop(name, _TIMEOUT_S)
        except Unreachable:
            if places.owner(name) is not None:  # else somebody else has ended it meanwhile
                raise


def _end_what_is_left(base: Path) -> None:
    """Kill what still bears the environment of the realm: slaves of a manager that was killed."""
    from rtkit.container.orphans import began_at, end_family, environment_of

    mark = f"RTKIT_RUNTIME_DIR={base / 'run'}".encode()
    for _ in range(_LOOKS):
        pids = [int(entry) for entry in os.listdir("/proc") if entry.isdigit()]
        left = {pid: began_at(pid) for pid in pids if mark in environment_of(pid)}
        if not left:
            return
        end_family(left)
        for pid in left:
            _reap(pid)


def _reap(pid: int) -> None:
    """Wait for the end of a process, if this one has started it."""
    if pid:
        with suppress(ChildProcessError):
            os.waitpid(pid, 0)


@contextmanager
def _noting_failures() -> Iterator[None]:
    try:
        yield
    except Exception as error:
        from rtkit.testing.failure import system

        for title, text in system():
            error.add_note(f"{title}\n{text}")
        raise


@contextmanager
def _environment(wished: Mapping[str, str | None]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in wished}
    _set(wished)
    try:
        yield
    finally:
        _set(before)


def _set(values: Mapping[str, str | None]) -> None:
    for name, text in values.items():
        if text is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = text
