"""A guest: a process that nobody here started, with components that the manager shows and wires.

Data tools are guests. What a guest holds is in the tree while it stays, is connected like anything
else, and goes without a trace when the guest does; the manager neither starts nor ends a guest.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence

from rtkit.component.base import Component
from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.link import places
from rtkit.link.streams import Streams
from rtkit.manager.core.message import Message
from rtkit.manager.holding.connect import Wires
from rtkit.manager.holding.holder import Holder
from rtkit.manager.processes.contact import Contact

_SETTLE_S = 0.5
"""How long senders may take to tell how many values they have sent [s]."""
_LEAVE_S = 2.0
"""How long leaving may take: connectors are cut, components finalised [s]."""


class Guest:
    """A visit of this process at a manager.

    Attributes:
        changed: Called after a component was ended, or a connection removed, from outside; by a
            thread of the guest's own.
    """

    def __init__(self, manager: str, host: str, name: str) -> None:
        self._manager = manager
        self._ending = _Leave()
        self._contact = Contact(
            places.control_socket(manager), f"{name}_{os.getpid()}", self._ending, is_guest=True
        )
        self._wires = Wires(host, Streams(places.data_socket(manager, os.getpid())))
        self._holder = Holder(self._send, self._wires, maker=None)
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
            Unreachable: The manager takes no guests, or does not answer in time.
        """
        self._start("holder", self._holder.run)
        self._hold(components, timeout_s)
        try:
            self._contact.visit(self._holder.tell_all, timeout_s)
        except OSError as error:
            raise Unreachable(f"manager {self._manager!r} takes no guests: {error}") from error
        self._start("control", lambda: self._contact.listen(self))
        if not self._welcomed.wait(timeout_s):
            raise Unreachable(f"manager {self._manager!r} does not answer within {timeout_s:g} s")
        for instance in sorted(self._held - set(self._welcome or ())):
            raise Refused(f"{instance} exists already")

    @property
    def holds(self) -> frozenset[str]:
        """Instance names of the components that live."""
        return frozenset(self._held)

    def flush(self, timeout_s: float) -> bool:
        """Wait until all that was sent has arrived; False when that cannot be said in time."""
        return self._wires.flush(timeout_s)

    def lost(self) -> int:
        """Return how many values were sent to its ports, numbered, and did not arrive."""
        return self._wires.lost(_SETTLE_S)

    def leave(self) -> None:
        """End all components and the visit; without effect when that was done already."""
        for instance in list(self._held):
            self._holder.put({"op": "delete", "instance": instance})
        if self._held:
            self._is_empty.wait(_LEAVE_S)
        self._ending.ask()
        self._holder.close()
        for thread in self._threads:
            thread.join(_LEAVE_S)

    def put(self, message: Message) -> None:
        """Take a message of the manager."""
        if "welcome" in message:
            self._welcome = list(message["welcome"])
            self._welcomed.set()
        else:
            self._holder.put(message)
            if message.get("op") == "unlink":
                self._holder.post(self.changed)

    def tell_all(self, tell: Callable[[Message], object]) -> None:
        """Call `tell` with everything that is held."""
        self._holder.tell_all(tell)

    def _hold(self, components: Sequence[Component], timeout_s: float) -> None:
        errors: list[RtkitError] = []
        done = threading.Event()

        def hold() -> None:
            try:
                for component in components:
                    self._holder.hold(component)
                    self._held.add(component.instance)
            except RtkitError as error:
                errors.append(error)
            done.set()

        self._holder.post(hold)
        if not done.wait(timeout_s):
            raise Unreachable(f"components do not initialise within {timeout_s:g} s")
        if errors:
            raise errors[0]

    def _send(self, message: Message) -> None:
        self._contact.send(message)
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
    """The end of a visit, asked for by the guest itself."""

    def __init__(self) -> None:
        self._read, self._write = os.pipe()

    def fileno(self) -> int:
        return self._read

    def ask(self) -> None:
        os.write(self._write, b"x")

    def has_come(self) -> bool:
        return bool(os.read(self._read, 1))
