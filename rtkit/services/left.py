"""Finds what a service started before it was killed: by a mark in the environment, in ``/proc``.

The mark stands in a process from its first instruction on, is passed on to all that it starts, and
is gone with them: there is no file that could be stale, or missing. Source: proc(5).
"""

from __future__ import annotations

import os
import select
import signal
from collections.abc import Collection, Iterator
from contextlib import suppress
from time import monotonic
from uuid import uuid4

_MARK = "RTKIT_STARTED"
_ENDING_S = 5.0
_LOOKS = 3
"""How often at most what was started meanwhile is looked for."""


def marked(socket: str, kind: str) -> dict[str, str]:
    """Return the environment of what the service at a socket starts, in which that can be seen."""
    return {**os.environ, _MARK: "\n".join((str(os.getpid()), uuid4().hex, socket, kind))}


class LeftProcess:
    """Process with all that it started, whose starter was killed.

    Attributes:
        kind: Of service.
    """

    def __init__(self, mark: str, pids: Collection[int]) -> None:
        self.kind = mark.split("\n")[3]
        self._mark, self._pids = mark, pids

    @property
    def is_running(self) -> bool:
        """Tells that one of them has not ended yet."""
        return any(map(self._is_one, self._pids))

    def stop(self, number: int = signal.SIGTERM) -> None:
        """Send a signal to all of them."""
        for descriptor in self._watched(self._pids):
            signal.pidfd_send_signal(descriptor, number)

    def end(self) -> None:
        """Stop them, by force if it takes long, and wait until they have ended."""
        until = monotonic() + _ENDING_S
        self.stop()
        self._await(until)
        for _ in range(_LOOKS):
            self._pids = [pid for pid in _processes() if self._is_one(pid)]
            self.stop(signal.SIGKILL)
            self._await(monotonic() + _ENDING_S)

    def _await(self, until: float) -> None:
        for descriptor in self._watched(self._pids):
            watching = select.poll()
            watching.register(descriptor, select.POLLIN)
            watching.poll(max(0.0, until - monotonic()) * 1000)

    def _watched(self, pids: Collection[int]) -> Iterator[int]:
        """Yield descriptors of those that live: their pids may be those of others any time."""
        for pid in pids:
            with suppress(ProcessLookupError):
                descriptor = os.pidfd_open(pid)
                try:
                    if self._is_one(pid):
                        yield descriptor
                finally:
                    os.close(descriptor)

    def _is_one(self, pid: int) -> bool:
        return _environment(pid).get(_MARK) == self._mark


def left_at(socket: str) -> list[LeftProcess]:
    """Return what a service at a socket, which is ours now, had started when it was killed."""
    found: dict[str, list[int]] = {}
    for pid in _processes():
        mark = _environment(pid).get(_MARK, "")
        if mark.split("\n")[2:3] == [socket]:
            found.setdefault(mark, []).append(pid)
    own = {mark for mark, pids in found.items() if any(map(_has_its_starter, pids))}
    return [LeftProcess(mark, pids) for mark, pids in found.items() if mark not in own]


def _has_its_starter(pid: int) -> bool:
    """Return whether the parent of a process is the one that its mark names."""
    with suppress(OSError), open(f"/proc/{pid}/stat", "rb") as file:
        parent = file.read().rpartition(b")")[2].split()[1].decode()
        return _environment(pid).get(_MARK, "").split("\n")[0] == parent
    return False


def _processes() -> list[int]:
    return [int(each) for each in os.listdir("/proc") if each.isdigit()]


def _environment(pid: int) -> dict[str, str]:
    """Return what a process was started with; nothing once it has ended, or if it is another's."""
    with suppress(OSError), open(f"/proc/{pid}/environ", "rb") as file:
        pairs = (each.partition(b"=") for each in file.read().split(b"\0"))
        return {os.fsdecode(name): os.fsdecode(value) for name, _, value in pairs}
    return {}
