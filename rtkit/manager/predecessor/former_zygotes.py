"""Connects to zygotes of earlier managers, which are still the parents of the slaves left.

Each listens at a path of its own; to the next manager it reports which children it has and what
became of others. It is never asked to fork, and ends with its last child.
"""

from __future__ import annotations

import contextlib
import glob
import logging
import os
import signal
from collections.abc import Collection

from rtkit.container.control_channel import ControlChannel
from rtkit.container.orphans import is_stopped
from rtkit.deployment.message import Message
from rtkit.errors import Malformed
from rtkit.link import unix
from rtkit.link.places import of_pid
from rtkit.link.processes import ProcessWatch

_END_S = 1.0
"""How long a zygote has to end after its last child [s]."""

_log = logging.getLogger(__name__)


class FormerZygotes:
    """Connections to former zygotes.

    Args:
        pattern: Their path, with ``%p`` for the pid.
        own: Pids of this manager's own, which listen as well.
    """

    def __init__(self, pattern: str, own: Collection[int] = ()) -> None:
        self._pattern = pattern
        self._own = own
        self._paths: dict[ControlChannel, str] = {}
        self._children: dict[ControlChannel, set[int]] = {}
        self._pids: dict[ControlChannel, int] = {}
        self._missing: set[int] = set()
        self._names: dict[int, str] = {}

    @property
    def missing(self) -> dict[int, str]:
        """Children that have not yet reported, with their names, if those are known."""
        return {pid: self._names.get(pid, "") for pid in self._missing}

    @property
    def is_complete(self) -> bool:
        """Return whether each that runs has told its children, and all that happened before."""
        silent = self._children.keys() - self._pids.keys()
        return all(is_stopped(unix.pid_of(channel.socket)) for channel in silent)

    def has(self, pid: int) -> bool:
        """Return whether a zygote will report the end of this process."""
        return any(pid in children for children in self._children.values())

    def find(self) -> list[ControlChannel]:
        """Connect to those that listen now; their first message names their children."""
        found = []
        known = {*self._paths.values(), *(of_pid(self._pattern, pid) for pid in self._own)}
        for path in {*glob.glob(of_pid(glob.escape(self._pattern), "*"))} - known:
            try:
                connection = unix.connect(path)
            except OSError:
                with contextlib.suppress(FileNotFoundError):
                    os.unlink(path)  # killed: nobody is behind it
                continue
            connection.setblocking(False)  # it may be stopped
            channel = ControlChannel(connection)
            self._children[channel], self._paths[channel] = set(), path
            found.append(channel)
        return found

    def receive(self, channel: ControlChannel) -> list[Message] | None:
        """Return what a zygote reports of processes; None when it ended."""
        try:
            messages = channel.receive()
        except (Malformed, OSError) as error:
            _log.warning("the line to an earlier zygote is broken: %s", error)
            messages = None
        if messages is None:
            self._missing -= self._children.pop(channel, set())
            self._pids.pop(channel, None)
            del self._paths[channel]
            channel.close()
            return None
        for message in messages:
            if "children" in message:
                self._children[channel].update(message["children"])
                self._missing.update(message["children"])
                self._pids[channel] = message["zygote"]
                self._names |= {int(pid): name for pid, name in message.get("names", {}).items()}
        return [message for message in messages if "children" not in message]

    def found(self, pid: int) -> None:
        """Note that a child has reported."""
        self._missing.discard(pid)

    def ended(self, pid: int) -> None:
        """Note that a child ended."""
        self._missing.discard(pid)
        for children in self._children.values():
            children.discard(pid)

    def close(self) -> None:
        """End children that never came back, and wait until the zygotes have ended too."""
        for children in self._children.values():
            for pid in children:
                _end(pid, 0.0)
        for channel in self._children:
            channel.close()
        for pid in self._pids.values():
            _end(pid, _END_S)
        self._children.clear()


def _end(pid: int, grace_s: float) -> None:
    """Kill a process that does not end by itself; a zygote that lives vouched for its pid."""
    with contextlib.suppress(ProcessLookupError), ProcessWatch(pid) as process:
        if not process.await_end(grace_s):
            process.send(signal.SIGKILL)
            process.await_end(_END_S)
