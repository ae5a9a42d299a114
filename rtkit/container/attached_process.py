"""Attaches a process that nobody here started: the manager shows and wires its components.

Data tools attach. The components of an attached process are in the tree while it stays, are
connected like any other, and vanish when it leaves; the manager neither starts nor ends it.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence

from rtkit.component.base import Component
from rtkit.container.container import ComponentContainer
from rtkit.container.manager_connection import ManagerConnection
from rtkit.container.port_wiring import PortWiring
from rtkit.deployment.message import Message
from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.link import places
from rtkit.link.streams import Streams

_SETTLE_S = 0.5
"""Time in which senders report how many values they have sent [s]."""
_LEAVE_S = 2.0
"""How long leaving may take: connectors are cut, components finalised [s]."""


class AttachedProcess:
    """Attaches this process to a manager, until it leaves.

    Attributes:
        changed: Called after a component was ended, or a connection removed, from outside; by a
            thread of the attached process's own.
    """

    def __init__(self, manager: str, host: str, name: str) -> None:
        self._manager = manager
        self._ending = _Leave()
        self._connection = ManagerConnection(
            places.control_socket(manager), f"{name}_{os.getpid()}", self._ending, is_guest=True
        )
        self._wiring = PortWiring(host, Streams(places.data_socket(manager, os.getpid())))
        self._container = ComponentContainer(self._send, self._wiring, component_factory=None)
        self._held: set[str] = set()
        self._is_empty = threading.Event()
        self._welcome: list[str] | None = None
        self._welcomed = threading.Event()
        self.changed: Callable[[], object] = lambda: None
        self._threads: list[threading.Thread] = []

    def enter(self, components: Sequence[Component], timeout_s: float) -> None:
        """Have components initialised, shown and ready to be connected.

        Raises:
            Refused: A component does not initialise, or its name is taken.
            Unreachable: The manager admits no attached processes, or does not answer in time.
        """
        self._start("holder", self._container.run)
        self._hold(components, timeout_s)
        try:
            self._connection.visit(self._container.report_all, timeout_s)
        except OSError as error:
            raise Unreachable(f"manager {self._manager!r} takes no guests: {error}") from error
        self._start(
            "control", lambda: self._connection.listen(self.put, self._container.report_all)
        )
        if not self._welcomed.wait(timeout_s):
            raise Unreachable(f"manager {self._manager!r} does not answer within {timeout_s:g} s")
        for instance in sorted(self._held - set(self._welcome or ())):
            raise Refused(f"{instance} exists already")

    @property
    def holds(self) -> frozenset[str]:
        """Instance names of the components that live."""
        return frozenset(self._held)

    def flush(self, timeout_s: float) -> bool:
        """Wait until all that was sent has arrived; False when that is not known in time."""
        return self._wiring.flush(timeout_s)

    def lost(self) -> int:
        """Return how many values were sent to its ports, numbered, and did not arrive."""
        return self._wiring.lost(_SETTLE_S)

    def leave(self) -> None:
        """End all components and detach; without effect when that was done already."""
        for instance in list(self._held):
            self._container.put({"op": "delete", "instance": instance})
        if self._held:
            self._is_empty.wait(_LEAVE_S)
        self._ending.ask()
        self._container.close()
        for thread in self._threads:
            thread.join(_LEAVE_S)

    def put(self, message: Message) -> None:
        """Take a message of the manager."""
        if "welcome" in message:
            self._welcome = list(message["welcome"])
            self._welcomed.set()
        else:
            self._container.put(message)
            if message.get("op") == "unlink":
                self._container.post(self.changed)

    def _hold(self, components: Sequence[Component], timeout_s: float) -> None:
        errors: list[RtkitError] = []
        done = threading.Event()

        def hold() -> None:
            try:
                for component in components:
                    self._container.hold(component)
                    self._held.add(component.instance)
            except RtkitError as error:
                errors.append(error)
            done.set()

        self._container.post(hold)
        if not done.wait(timeout_s):
            raise Unreachable(f"components do not initialise within {timeout_s:g} s")
        if errors:
            raise errors[0]

    def _send(self, message: Message) -> None:
        self._connection.send(message)
        if "gone" in message:
            instance = message["gone"]
            self._held.discard(instance)
            if not self._held:
                self._is_empty.set()
            self.changed()

    def _start(self, name: str, work: Callable[[], object]) -> None:
        thread = threading.Thread(target=work, name=f"guest {name}", daemon=True)
        self._threads.append(thread)
        thread.start()


class _Leave:
    """Request of the attached process to leave its manager."""

    def __init__(self) -> None:
        self._read, self._write = os.pipe()

    def fileno(self) -> int:
        return self._read

    def ask(self) -> None:
        os.write(self._write, b"x")

    def has_come(self) -> bool:
        return bool(os.read(self._read, 1))
