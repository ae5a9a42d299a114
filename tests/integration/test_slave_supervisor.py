"""The manager's side of a real zygote: whom it takes for its own, and what it clears away."""

from __future__ import annotations

import os
import select
import selectors
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from rtkit.container.control_channel import ControlChannel
from rtkit.container.slave_checkpoint import checkpoint_path
from rtkit.manager.core.events import SlaveEnded, SlaveForked
from rtkit.manager.slaves.slave_connections import SlaveConnections
from rtkit.manager.slaves.slave_supervisor import SlaveSupervisor

KEY = 1


class Side:
    """A nursery with a zygote, and the socket at which slaves greet."""

    def __init__(self, folder: Path) -> None:
        self.data = str(folder / "m.%p.data")
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(str(folder / "m.ctl"))
        self.listener.listen()
        self.slave_supervisor = SlaveSupervisor(
            {
                "manager": "m",
                "is_shown": False,
                "control": str(folder / "m.ctl"),
                "data": self.data,
                "host": "h",
                "load_path": [],
                "zygote": str(folder / "m.%p.zygote"),
            }
        )

    def told(self, kind: type) -> object:
        """Return the next event of that kind."""
        while True:
            assert select.select([self.slave_supervisor], [], [], 30.0)[0], kind
            for event in self.slave_supervisor.receive() or ():
                if isinstance(event, kind):
                    return event

    def greeting(self) -> dict[str, object]:
        """Return what the next slave says first."""
        self.listener.settimeout(30.0)
        connection, _ = self.listener.accept()
        (message,) = ControlChannel(connection).receive() or [{}]
        connection.close()
        return dict(message)

    def close(self) -> None:
        self.slave_supervisor.close()
        self.listener.close()


@pytest.fixture
def side(monkeypatch: pytest.MonkeyPatch) -> Iterator[Side]:
    with tempfile.TemporaryDirectory(prefix="rt") as folder:
        monkeypatch.setenv("RTKIT_RUNTIME_DIR", folder)
        monkeypatch.setenv("RTKIT_STATE_DIR", folder)
        side = Side(Path(folder))
        yield side
        side.close()


def test_who_is_taken_for_its_own_and_what_is_left_of_who_is_killed(side: Side) -> None:
    """A slave of an earlier manager may have the key of one of ours: it waited long to greet."""
    slave_supervisor = side.slave_supervisor
    slave_supervisor.fork(KEY, "s")
    first = side.greeting()
    pid, of = first["pid"], first["of"]
    assert not slave_supervisor.expects(KEY, pid, "1.1")
    assert not slave_supervisor.expects(KEY, os.getpid(), None)
    assert side.told(SlaveForked) == SlaveForked(KEY, int(str(pid)))
    assert slave_supervisor.expects(KEY, pid, of)
    assert not slave_supervisor.expects(KEY, os.getpid(), of)
    checkpoint_writer = checkpoint_path(side.data, int(str(pid)))
    assert os.path.exists(checkpoint_writer)
    slave_supervisor.signal(KEY, signal.SIGKILL)
    assert not os.path.exists(checkpoint_writer)
    assert side.told(SlaveEnded) == SlaveEnded(KEY, "signal 9")


def test_who_is_wanted_between_two_zygotes_is_born_of_the_next_one(side: Side) -> None:
    slave_supervisor = side.slave_supervisor
    (zygote,) = slave_supervisor.processes
    os.kill(zygote, signal.SIGKILL)
    while slave_supervisor.receive() is not None:
        assert select.select([slave_supervisor], [], [], 30.0)[0], "the end of the zygote"
    slave_supervisor.on_zygote_exit()
    slave_supervisor.fork(KEY, "s")
    slave_supervisor.restart()
    first = side.greeting()
    assert slave_supervisor.expects(KEY, first["pid"], first["of"])
    slave_supervisor.signal(KEY, signal.SIGKILL)
    assert side.told(SlaveEnded) == SlaveEnded(KEY, "signal 9")


def test_its_own_zygote_that_warms_up_is_no_slave_that_has_not_reported(
    side: Side, monkeypatch: pytest.MonkeyPatch
) -> None:
    (zygote,) = side.slave_supervisor.processes
    Path(side.data.replace("%p.data", f"{zygote}.beats")).touch()
    monkeypatch.setattr("rtkit.manager.predecessor.unreported.is_slave", lambda *_: True)
    side.slave_supervisor.look_for_absent()
    assert side.slave_supervisor.is_complete


def test_a_stranger_with_the_pid_of_a_guest_that_left_is_let_be(side: Side) -> None:
    slave_supervisor = side.slave_supervisor
    with subprocess.Popen(["sleep", "60"]) as stranger:
        assert slave_supervisor.adopt(KEY, stranger.pid, is_guest=True) is not None
        assert not slave_supervisor.is_unwatched(KEY)
        slave_supervisor.distrust_pid(KEY)
        assert slave_supervisor.is_unwatched(KEY)
        slave_supervisor.signal(KEY, signal.SIGKILL)
        assert slave_supervisor.lost(KEY) == SlaveEnded(KEY, "exit status unknown")
        slave_supervisor.sweep()
        assert stranger.poll() is None
        stranger.kill()


def test_what_a_killed_slave_forks_ends_with_it_though_no_zygote_looks(side: Side) -> None:
    """Each process forks one and exits, as those of a fork bomb may while others are killed."""
    fleeing = "import os, signal\nif os.fork():\n print(flush=True)\n signal.pause()\n"
    fleeing += "while True:\n os.fork() and os._exit(0)"
    command = [sys.executable, "-c", fleeing]
    slave = subprocess.Popen(command, stdout=subprocess.PIPE, start_new_session=True)
    assert slave.stdout is not None
    try:
        slave.stdout.readline()
        side.slave_supervisor.adopt(KEY, slave.pid)
        side.slave_supervisor.signal(KEY, signal.SIGKILL)
        assert select.select([slave.stdout], [], [], 5.0)[0], "somebody still holds the pipe"
    finally:
        with suppress(ProcessLookupError):
            os.killpg(slave.pid, signal.SIGKILL)
        slave.wait()
        slave.stdout.close()


def test_a_slave_whose_zygote_tells_of_its_end_is_watched_no_more(side: Side) -> None:
    """The number of its descriptor is given to the next connection, which is to be registered."""
    told: list[object] = []
    with (
        selectors.DefaultSelector() as selector,
        socket.socket(socket.AF_UNIX) as zygote,
        subprocess.Popen(["sleep", "60"]) as slave,
    ):
        supervisor = side.slave_supervisor
        connections = SlaveConnections(selector, side.listener, supervisor, told.append)
        connections.adopt(KEY, slave.pid)
        pidfd = supervisor.pidfd_of(KEY)
        assert pidfd in selector.get_map()
        zygote.bind(side.data.replace("%p.data", f"{slave.pid}.zygote"))
        zygote.listen()
        connections.settle(lambda: None)
        connection, _ = zygote.accept()
        channel = ControlChannel(connection)
        channel.send({"children": [slave.pid], "names": {}, "zygote": slave.pid})
        channel.send({"ended": slave.pid, "reason": "signal 9"})
        while SlaveEnded(KEY, "signal 9") not in told:
            for key, mask in selector.select(30.0):
                key.data(mask)
        assert pidfd not in selector.get_map()
        slave.kill()
        connections.close()
        channel.close()
