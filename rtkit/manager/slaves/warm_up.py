"""Warms up the zygote: goes through the first moments of a slave before any is forked.

Results that Python works out at first use are then there in every slave, cost no time in any, and
memory once for all: coders of records, answers of abstract classes, byte code that is fitted to the
types it met. The latter takes a few times. Done between two requests, with the files and threads of
a real slave, and without what would change this process: descriptors, signals, environment.

Last of all the heap is compacted. A page that a slave writes to becomes its own, and is copied
first. New objects would go into gaps all over the memory that it has in common with the others;
where those are filled, they go to new pages, of which it needs but few.

See decision 49.
"""

from __future__ import annotations

import contextlib
import os
import socket
import sys
import threading
from typing import Any

from rtkit.container.component_factory import ComponentFactory
from rtkit.container.container import ComponentContainer
from rtkit.container.control_channel import ControlChannel
from rtkit.container.heartbeats import Heartbeats, heartbeats_path
from rtkit.container.manager_connection import ManagerConnection
from rtkit.container.port_wiring import PortWiring
from rtkit.container.slave_checkpoint import CheckpointWriter
from rtkit.deployment.message import Message
from rtkit.link.local.streams import LocalStreams
from rtkit.link.places import of_pid
from rtkit.logs.logs import Log
from rtkit.modules.loader import Loader
from rtkit.modules.neighbours import disown

_FOLDER = os.path.dirname(os.path.abspath(__file__))
_LAST = 2
# As a manager asks for a type of which nobody has loaded the module.
_LINES: tuple[Message, ...] = (
    {
        "op": "create",
        "create": "warm_up_component?instance_name=Extra0&manager_name=rehearsal",
        "pattern": None,
        "modules": [],
        "inherited": {},
        "config_files": {},
        "kept": {"names": ["localhost/Extra0.rtc"], "create": "warm_up_component"},
        "call": 1,
    },
    {"op": "delete", "instance": "Extra0", "call": _LAST},
)


def warm_up(log: Log, settings: Any) -> None:
    """Begin a log, greet, make a component, report it, end it.

    Its files are named after this process, so that the next manager clears them away should it be
    killed here; its checkpoint has a name of its own, as there are no components to miss.

    Args:
        log: Of this process.
        settings: Of slaves (see `rtkit.container.slave`).

    Raises:
        RuntimeError: Something failed that slaves do all the time.
    """
    pattern, pid = settings["data"], os.getpid()
    place = of_pid(pattern, pid)
    stem = place.removesuffix(".data")
    paths = [place, heartbeats_path(pattern, pid), f"{stem}.rehearsal", f"{stem}.rehearsed"]
    modules, search_path = set(sys.modules), list(sys.path)
    with contextlib.ExitStack() as stack, log.lent("rehearsal", paths[2]):
        stack.callback(_remove, paths)
        listener = stack.enter_context(socket.socket(socket.AF_UNIX))
        listener.bind(place)
        listener.listen(1)
        log.begin()
        _Stage(place, Heartbeats(paths[1]), CheckpointWriter(paths[3], "rehearsal")).play(listener)
    disown(_FOLDER)
    sys.path[:] = search_path
    for name in set(sys.modules) - modules:
        del sys.modules[name]


def _remove(paths: list[str]) -> None:
    for path in paths:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(path)


class _Stage:
    """A container on this thread, connected to a manager on another one, as in a slave."""

    def __init__(
        self, place: str, heartbeats: Heartbeats, checkpoint_writer: CheckpointWriter
    ) -> None:
        self._read, self._write = os.pipe()
        self._connection = ManagerConnection(place, "rehearsal", self)
        self._replies: list[Message] = []
        wiring = PortWiring("", LocalStreams(place))
        self._container = ComponentContainer(
            self._send, wiring, ComponentFactory(Loader([_FOLDER]))
        )
        self._container.show_heartbeats(heartbeats)
        self._container.write_down(checkpoint_writer)

    def play(self, listener: socket.socket) -> None:
        self._connection.greet(0, "")
        connection, _ = listener.accept()
        other = ControlChannel(connection)
        for line in _LINES:
            other.send(line)
        control = threading.Thread(target=self._listen, name="control", daemon=True)
        control.start()
        self._container.run()
        control.join()
        other.close()
        os.close(self._read)
        os.close(self._write)
        failed = [reply for reply in self._replies if "kind" in reply]
        if failed or len(self._replies) != len(_LINES):
            raise RuntimeError(f"rehearsal: {failed or self._replies}")

    def fileno(self) -> int:
        return self._read

    def has_come(self) -> bool:
        return bool(os.read(self._read, 1))

    def _listen(self) -> None:
        try:
            self._connection.listen(self._container.put, self._container.report_all)
        finally:
            self._container.close()

    def _send(self, message: Message) -> None:
        self._connection.send(message)
        if "reply" in message:
            self._replies.append(message)
            if message["reply"] == _LAST:
                os.write(self._write, b"x")


_LARGEST, _STEP = 512, 16
"""Of what sizes Python keeps gaps in pools of one size each [bytes]."""

_HEAD = 33
"""Memory that an object of bytes needs beside them [bytes]."""

_RUN = 8
"""So many objects one behind the other lie in a pool that was empty."""

_MOST = 1024
"""How many gaps of one size are filled at most, should the allocator be another one."""


def fill_gaps() -> list[bytes]:
    """Return what now lies where objects were; it is to be kept."""
    filling: list[bytes] = []
    for size in range(_HEAD // _STEP * _STEP + _STEP, _LARGEST + 1, _STEP):
        filled: list[bytes] = []
        while len(filled) < _MOST and not _is_run(filled[-_RUN:], size):
            filled.append(bytes(size - _HEAD))
        filling += filled[:-_RUN]
    return filling


def _is_run(last: list[bytes], size: int) -> bool:
    places = [id(each) for each in last]
    return len(places) == _RUN and places == list(range(places[0], places[0] + _RUN * size, size))
