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
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.rtc.serde import encode

_FOLDER = os.path.dirname(os.path.abspath(__file__))
_END_S = 10.0
_OUT, _INTO = (
    ConnectorProfile(name, name, (PortRef(out, "out"), PortRef(into, "into")))
    for name, out, into in (("out", "Extra0", "Extra1"), ("into", "Extra1", "Extra0"))
)
"""Connectors to another slave, and from it."""
# As a manager asks for a type of which nobody has loaded the module.
_LINES: tuple[Message, ...] = (
    {
        "op": "create",
        "create": "warm_up_component?instance_name=Extra0&manager_name=rehearsal",
        "pattern": None,
        "modules": [],
        "inherited": {},
        "config_files": {},
        "given": {},
        "kept": {"names": ["localhost/Extra0.rtc"], "create": "warm_up_component"},
    },
    {"op": "source", "connector": encode(_OUT)},
    {"op": "sink", "connector": encode(_INTO)},
    {"op": "unlink", "connector_id": _OUT.connector_id},
    {"op": "unlink", "connector_id": _INTO.connector_id},
    {"op": "delete", "instance": "Extra0"},
)


def warm_up(log: Log, settings: Any) -> None:
    """Begin a log, greet, make a component, report it, connect it to another process, end it.

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
    names = ("rehearsal", "rehearsed", "stage", "other")  # see `rtkit.manager.claim`
    more = [f"{stem}.{name}" for name in names]
    paths = [place, heartbeats_path(pattern, pid), *more]
    modules, search_path = set(sys.modules), list(sys.path)
    threads = set(threading.enumerate())
    with contextlib.ExitStack() as stack, log.lent("rehearsal", more[0]):
        stack.callback(_remove, paths)
        listener = stack.enter_context(socket.socket(socket.AF_UNIX))
        listener.bind(more[2])
        listener.listen(1)
        log.begin()
        other = _Other(f"{pattern.removesuffix('.data')}.other")
        stack.callback(other.close)
        stage = _Stage(pattern, more[2], other)
        stage.show(Heartbeats(paths[1]), CheckpointWriter(more[1], "rehearsal"))
        stage.play(listener)
    _await_ends(threads)
    disown(_FOLDER)
    sys.path[:] = search_path
    for name in set(sys.modules) - modules:
        del sys.modules[name]


def _await_ends(before: set[threading.Thread]) -> None:
    """Wait until the threads have ended that were not there before: a fork would lose them."""
    for thread in set(threading.enumerate()) - before:
        thread.join(_END_S)
        if thread.is_alive():
            raise RuntimeError(f"rehearsal: thread {thread.name} does not end")


def _remove(paths: list[str]) -> None:
    for path in paths:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(path)


class _Other:
    """The other end of connectors, as another slave has it.

    Attributes:
        endpoint: At which it waits for values.
    """

    def __init__(self, path: str) -> None:
        from rtkit.manager.slaves.warm_up_component import Extra

        self._wiring = PortWiring("", LocalStreams(path))
        self.endpoint = self._wiring.receive(_OUT, Extra("Extra1").into)

    def send_to(self, endpoint: str) -> None:
        """Connect to the end that waits for values there."""
        self._wiring.keep(_INTO, self._wiring.find_receiver(_INTO, endpoint))

    def close(self) -> None:
        """End all of it."""
        self._wiring.close()


class _Stage:
    """A container on this thread, connected to a manager on another one, as in a slave."""

    def __init__(self, pattern: str, manager: str, other: _Other) -> None:
        self._read, self._write = os.pipe()
        self._connection = ManagerConnection(manager, "rehearsal", self)
        self._other = other
        self._lines = iter(_LINES)
        self._manager: ControlChannel
        self._replies: list[Message] = []
        wiring = PortWiring("", LocalStreams(pattern))
        self._container = ComponentContainer(
            self._send, wiring, ComponentFactory(Loader([_FOLDER]))
        )

    def show(self, heartbeats: Heartbeats, checkpoint_writer: CheckpointWriter) -> None:
        self._container.show_heartbeats(heartbeats)
        self._container.write_down(checkpoint_writer)

    def play(self, listener: socket.socket) -> None:
        self._connection.greet(0, "")
        connection, _ = listener.accept()
        self._manager = ControlChannel(connection)
        self._ask()
        control = threading.Thread(target=self._listen, name="control", daemon=True)
        control.start()
        self._container.run()
        control.join()
        self._manager.close()
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

    def _ask(self) -> None:
        """Send the next line, as the manager that it comes from would; after the last, the end."""
        line = next(self._lines, None)
        if line is None:
            os.write(self._write, b"x")
        else:
            call = {"call": line["op"], "endpoint": self._other.endpoint}
            self._manager.send({**line, **call})

    def _send(self, message: Message) -> None:
        self._connection.send(message)
        if "reply" in message:
            self._replies.append(message)
            if message["reply"] == "sink" and "kind" not in message:
                self._other.send_to(message["value"])
            self._ask()


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
