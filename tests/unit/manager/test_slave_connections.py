"""Connections of processes to their manager: ends that are told twice."""

from __future__ import annotations

import os
import selectors
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rtkit.container.control_channel import ControlChannel
from rtkit.container.manager_connection import LEAVES, PROTOCOL
from rtkit.manager.core import events as ev
from rtkit.manager.slaves.slave_connections import SlaveConnections

KEY = 7
HELLO = {"found": "tool", "pid": os.getpid(), "protocol": PROTOCOL, "guest": True}


class OneGuest:
    """A supervisor whose only process is a guest; a pipe stands in for its pidfd."""

    former_zygotes: Any
    unwatch: Callable[[int], object]

    def __init__(self) -> None:
        self._fd, self._other = os.pipe()
        self.pidfd, self._end = os.pipe()
        self.former_zygotes = self
        self.is_complete = True
        self._pidfds: dict[int, int] = {}

    def fileno(self) -> int:
        return self._fd

    def find(self) -> list[ControlChannel]:
        return []

    def expects(self, _key: object, _pid: int, _of: object) -> bool:
        return False

    def adopt(self, key: int, _pid: int, *, is_guest: bool) -> int:
        assert is_guest
        self._pidfds[key] = self.pidfd
        return self.pidfd

    def is_guest(self, _key: int) -> bool:
        return True

    def is_unwatched(self, _key: int) -> bool:
        return False

    def pidfd_of(self, key: int) -> int | None:
        return self._pidfds.get(key)

    def is_orphan(self, key: int) -> bool:
        return key in self._pidfds

    def lost(self, key: int) -> ev.Event | None:
        known = self._pidfds.pop(key, None)
        if known is None:
            return None
        self.unwatch(known)
        return ev.SlaveEnded(key, "exit status unknown")

    def die(self) -> None:
        os.write(self._end, b"x")

    def close(self) -> None:
        for descriptor in (self._fd, self._other, self.pidfd, self._end):
            os.close(descriptor)


@pytest.fixture
def listener(tmp_path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "s"))
        listener.listen()
        listener.setblocking(False)
        yield listener


@pytest.mark.parametrize("is_pidfd_first", [False, True])
def test_a_guest_that_leaves_and_ends_in_one_turn_ends_once(
    listener: socket.socket, *, is_pidfd_first: bool
) -> None:
    told: list[ev.Event] = []
    guest = OneGuest()
    connections: SlaveConnections

    def handle(event: ev.Event) -> None:
        told.append(event)
        if isinstance(event, ev.SlaveFound):
            connections.adopt(KEY, event.pid, is_guest=event.is_guest)

    with selectors.DefaultSelector() as selector, socket.socket(socket.AF_UNIX) as tool:
        connections = SlaveConnections(selector, listener, guest, handle)  # type: ignore[arg-type]
        tool.connect(listener.getsockname())
        channel = ControlChannel(tool)
        channel.send(HELLO)
        _turn(selector)  # accepts
        _turn(selector)  # greets
        channel.send({LEAVES: True})
        guest.die()
        _turn(selector, lambda fd: (fd == guest.pidfd) is not is_pidfd_first)
        connections.close()
        guest.close()
    assert [type(event) for event in told] == [ev.SlaveFound, ev.SlaveEnded]


def _turn(
    selector: selectors.BaseSelector, order: Callable[[int], bool] = lambda _fd: False
) -> None:
    for key, mask in sorted(selector.select(1.0), key=lambda ready: order(ready[0].fd)):
        key.data(mask)
