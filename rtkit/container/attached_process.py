"""Attaches a process that nobody here started: the manager shows and wires its components.

Data tools attach, and components that their author runs by hand. The components of an attached
process are in the tree while it stays, are connected like any other, and vanish when it leaves; the
manager neither starts nor ends it.
"""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rtkit.component.base import Component
from rtkit.container.composites import is_composite
from rtkit.container.container import ComponentContainer
from rtkit.container.manager_connection import ManagerConnection
from rtkit.container.pacer import StartDriver
from rtkit.container.port_wiring import PortWiring
from rtkit.deployment.message import Message
from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.link import places
from rtkit.link.local.streams import LocalStreams
from rtkit.link.threads import start_thread

if TYPE_CHECKING:
    from rtkit.component.composite import Composite

_SETTLE_S = 0.5
"""Time in which senders report how many values they have sent [s]."""
_LEAVE_S = 2.0
"""How long leaving may take: connectors are cut, components finalised [s]."""


class AttachedProcess:
    """Attaches this process to a manager, until it leaves.

    Attributes:
        manager: Its name.
        listeners: Called after a component was ended, or a connection removed, from outside; by a
            thread of the attached process's own.
    """

    def __init__(self, manager: str, host: str, name: str) -> None:
        self.manager = manager
        self._ending = _Leave()
        self._connection = ManagerConnection(
            places.control_socket(manager), f"{name}_{os.getpid()}", self._ending, is_guest=True
        )
        self._wiring = PortWiring(
            host, LocalStreams(places.data_socket(manager, os.getpid())), manager
        )
        self._container = ComponentContainer(self._send, self._wiring, component_factory=None)
        self._held: set[str] = set()
        self._stacks: int | None = None
        self._departures = threading.Condition()
        self._welcome: list[str] | None = None
        self._welcomed = threading.Event()
        self.listeners: list[Callable[[], object]] = []
        self._threads: list[threading.Thread] = []

    def be_watched(self) -> None:
        """Show the manager in which callbacks this process is, before it enters.

        Raises:
            OSError: Its marker file cannot be written.
        """
        # Tools do without, so they do not wait for these imports.
        from rtkit.container.heartbeats import Heartbeats
        from rtkit.container.stacks import open_stacks

        pattern, path = self._heartbeats()
        self._container.show_heartbeats(Heartbeats(path))
        self._stacks = open_stacks(pattern, os.getpid())

    def enter(
        self,
        components: Sequence[Component],
        timeout_s: float,
        kept: Mapping[str, Any] | None = None,
        start: StartDriver = start_thread,
    ) -> None:
        """Have components initialised if they are not, shown and ready to be connected.

        Args:
            components: Further ones, if this was done before.
            timeout_s: Bound on each step [s].
            kept: Facts about them that they do not know themselves: how they are made again.
            start: Starts the work of their contexts.

        Raises:
            Refused: A component does not initialise, or its name is taken.
            Unreachable: The manager admits no attached processes, or does not answer in time.
        """
        is_first = not self._threads
        if is_first:
            self._start("holder", self._container.run)
        self._welcomed.clear()
        self._hold(components, timeout_s, kept or {}, start)
        if not is_first:
            self._connection.renew()
        else:
            try:
                self._connection.visit(self._container.report_all, timeout_s)
            except OSError as error:
                raise Unreachable(f"manager {self.manager!r} takes no guests: {error}") from error
            self._start(
                "control", lambda: self._connection.listen(self.put, self._container.report_all)
            )
        if not self._welcomed.wait(timeout_s):
            raise Unreachable(f"manager {self.manager!r} does not answer within {timeout_s:g} s")
        entered = {component.instance for component in components}
        for instance in sorted(entered - set(self._welcome or ())):
            raise Refused(f"{instance} exists already")

    def change(self, component: Component, how: Callable[[], object]) -> None:
        """Have a component changed by the thread that holds it, and shown as it is then."""

        def change() -> None:
            how()
            self._container.report(component)

        self._container.post(change)

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

    def end(self, instances: Collection[str]) -> None:
        """End components; without effect on those that have ended."""
        for instance in self._held.intersection(instances):
            self._container.put({"op": "delete", "instance": instance})
        with self._departures:
            self._departures.wait_for(lambda: self._held.isdisjoint(instances), _LEAVE_S)

    def leave(self) -> None:
        """End all components and detach; without effect when that was done already."""
        self.end(self.holds)
        self._container.post(self._take_leave)
        self._container.close()
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(_LEAVE_S)
        if not any(thread.is_alive() for thread in self._threads):
            self._ending.close()
        if self._stacks is not None:
            os.close(self._stacks)
            self._stacks = None
            with contextlib.suppress(FileNotFoundError):  # the manager was quicker
                os.unlink(self._heartbeats()[1])

    def put(self, message: Message) -> None:
        """Take a message of the manager."""
        if self._stacks is not None and self._is_for_stacks(message, self._stacks):
            return
        if "welcome" in message:
            self._welcome = list(message["welcome"])
            self._welcomed.set()
        else:
            self._container.put(message)
            if message.get("op") == "unlink":
                self._container.post(self._changed)

    def _changed(self) -> None:
        for listener in tuple(self.listeners):
            listener()

    def _heartbeats(self) -> tuple[str, str]:
        from rtkit.container.heartbeats import guest_pattern, heartbeats_path

        pattern = guest_pattern(places.data_socket(self.manager, os.getpid()))
        return pattern, heartbeats_path(pattern, os.getpid())

    @staticmethod
    def _is_for_stacks(message: Message, stacks: int) -> bool:
        from rtkit.container.stacks import ASK, write_stacks

        is_asked = message.get("op") == ASK
        if is_asked:
            write_stacks(stacks)
        return is_asked

    def _hold(
        self,
        components: Sequence[Component],
        timeout_s: float,
        kept: Mapping[str, Any],
        start: StartDriver,
    ) -> None:
        errors: list[RtkitError] = []
        done = threading.Event()
        composites: list[Composite] = []

        def hold() -> None:
            self._container.start_driver = start
            try:
                for component in components:
                    is_new = not component.is_alive
                    (self._container.hold if is_new else self._container.drive)(component, kept)
                    self._held.add(component.instance)
                    if is_composite(component):
                        composites.append(component)
            except RtkitError as error:
                errors.append(error)
            compose(None)

        def compose(error: RtkitError | None) -> None:
            errors.extend([error] if error is not None else [])
            if composites and not errors:
                self._container.composites.arrange(composites.pop(0), compose)
            else:
                done.set()

        self._container.post(hold)
        if not done.wait(timeout_s):
            raise Unreachable(f"components do not initialise within {timeout_s:g} s")
        if errors:
            raise errors[0]

    def _take_leave(self) -> None:
        self._connection.take_leave()
        self._ending.ask()

    def _send(self, message: Message) -> None:
        self._connection.send(message)
        if "gone" in message:
            with self._departures:
                self._held.discard(message["gone"])
                self._departures.notify_all()
            self._changed()

    def _start(self, name: str, work: Callable[[], object]) -> None:
        thread = threading.Thread(target=work, name=f"guest {name}", daemon=True)
        self._threads.append(thread)
        thread.start()


ENTERING = threading.RLock()
"""Held by a thread that has a component enter, or leaves."""
_here: dict[str, AttachedProcess] = {}
"""This process, by the managers that it is attached to: each knows it once, whatever it runs."""


def attached_to(
    manager: str, host: str, name: str, prepare: Callable[[AttachedProcess], object]
) -> AttachedProcess:
    """Return this process as its manager knows it; `prepare` one that is new.

    Whoever calls holds `ENTERING` until its component has entered.
    """
    if manager not in _here:
        attached = AttachedProcess(manager, host, name)
        prepare(attached)
        _here[manager] = attached
    return _here[manager]


def leave_if_empty(attached: AttachedProcess) -> None:
    """Detach this process from a manager if it holds nothing there any more."""
    with ENTERING:
        if not attached.holds and _here.get(attached.manager) is attached:
            del _here[attached.manager]
            attached.leave()


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

    def close(self) -> None:
        if self._read >= 0:
            os.close(self._read)
            os.close(self._write)
        self._read = self._write = -1
