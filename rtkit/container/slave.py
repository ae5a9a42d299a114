"""Runs a slave: a process of components that obeys its manager over a private socket.

It outlives its manager (see `rtkit.container.manager_connection`) and ends at a manager's request.
"""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
import _thread
import contextlib
import faulthandler
import os
import signal
from typing import Any

from rtkit import fault
from rtkit.container.component_factory import ComponentFactory
from rtkit.container.container import ComponentContainer
from rtkit.container.heartbeats import Heartbeats, heartbeats_path
from rtkit.container.manager_connection import ManagerConnection
from rtkit.container.orphans import MARK, Adopted, become_subreaper, end_children
from rtkit.container.port_wiring import PortWiring
from rtkit.container.slave_checkpoint import CheckpointWriter, checkpoint_path
from rtkit.container.stacks import ASK, STACK_SIGNAL, open_stacks, write_stacks
from rtkit.container.stdin import give_stdin
from rtkit.deployment.message import Message
from rtkit.link.local.streams import LocalStreams
from rtkit.logs.logs import Log, hand_over
from rtkit.modules.loader import Loader

LAST_S = 5
"""Grace that components have to finalise after a TERM, if nobody sends a KILL before [s]."""


class Slave:
    """Slave before the fork: all that does not depend on which slave it becomes.

    The zygote has one, and every fork is a copy of it: what is made here costs time once, and
    memory once for all of them.

    Args:
        settings: ``manager``, ``control`` and ``data`` (socket paths), ``host``, ``load_path``.
        log: Of the zygote, which becomes that of the slave.
    """

    def __init__(self, settings: Any, log: Log) -> None:
        self._settings = settings
        self._log = log
        self._connection: ManagerConnection
        self._stacks: int
        wiring = PortWiring(settings["host"], LocalStreams(settings["data"]), settings["manager"])
        paths = list(settings["load_path"])
        factory = ComponentFactory(Loader(paths), paths)
        self._container = ComponentContainer(self._send, wiring, factory)
        self._container.terminals.has_descriptor = True
        give_stdin(self._container.terminals)

    def live(self, key: int, name: str) -> None:
        """Hold components until a TERM arrives; called once, after the fork.

        Args:
            key: Under which the manager knows this process.
            name: Name of the slave.
        """
        with hand_over(self._log, self._settings["manager"], name):
            self._hold(key, name)

    def _hold(self, key: int, name: str) -> None:
        pid, data = os.getpid(), self._settings["data"]
        os.environ[MARK] = str(pid)
        fault.point("slave.begun")
        _name_process(f"rtkit {name}")
        self._connection = connection = ManagerConnection(
            self._settings["control"], name, Term(), at_leisure=Adopted().look
        )
        self._container.show_heartbeats(Heartbeats(heartbeats_path(data, pid)))
        self._container.write_down(CheckpointWriter(checkpoint_path(data, pid), name))
        self._stacks = open_stacks(data, pid)
        faulthandler.register(STACK_SIGNAL, self._stacks, all_threads=True)
        fault.point("slave.greeting")
        connection.greet(key, self._settings["manager_run"])
        os.setsid()  # until now it was to end with its zygote
        become_subreaper()
        fault.point("slave.greeted")
        # One of `threading` touches 50 kB more, and waits until the other thread had its turn.
        _thread.start_new_thread(self._listen, ())
        self._container.run()
        fault.point("slave.holds_nothing")
        end_children()

    def put(self, message: Message) -> None:
        """Take a message of the manager, on the thread that receives it."""
        if message.get("op") == ASK:
            with contextlib.suppress(OSError):  # a component has closed the file
                write_stacks(self._stacks)
        else:
            self._container.put(message)

    def _send(self, message: Message) -> None:
        self._connection.send(message)

    def _listen(self) -> None:
        try:
            self._connection.listen(self.put, self._container.report_all)
        finally:
            fault.point("slave.told_to_end")
            self._container.close()
            signal.alarm(LAST_S)  # ends the process, also one in which a component hangs


class Term:
    """Descriptor that turns readable at TERM, whichever thread the kernel delivers that to.

    A handler alone would run only when the main thread next leaves a wait of its own.
    """

    def __init__(self) -> None:
        self._read, write = os.pipe()
        for descriptor in (self._read, write):
            os.set_blocking(descriptor, False)
        # That of `signal` looks the former handler up in an enum, and touches 90 kB for it.
        _signal.signal(signal.SIGTERM, lambda *_: None)
        signal.set_wakeup_fd(write, warn_on_full_buffer=False)

    def fileno(self) -> int:
        """Return the descriptor that turns readable at any signal."""
        return self._read

    def has_come(self) -> bool:
        """Return whether a TERM was among the signals."""
        return signal.SIGTERM in os.read(self._read, 4096)


def _name_process(name: str) -> None:
    descriptor = os.open("/proc/self/comm", os.O_WRONLY)
    try:
        os.write(descriptor, name.encode("utf-8", "replace"))
    finally:
        os.close(descriptor)
