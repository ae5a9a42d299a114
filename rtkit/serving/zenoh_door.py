"""The zenoh door of a service: queries of what is kept are answered at once, others on the loop."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable

from rtkit.link import keys, places
from rtkit.link.properties import LEASE_S, PropertyDoor, Queried
from rtkit.link.streams import remove_socket
from rtkit.link.zenoh import open_listener, unix_endpoint
from rtkit.property.codes import PropertyError
from rtkit.property.listening import Listener
from rtkit.property.messages import Answer, Ask, Caller, Event
from rtkit.serving.host import Host
from rtkit.serving.owner import Owner
from rtkit.serving.room import Room

_RETRY = '{"period_init_ms": 500, "period_max_ms": 5000, "period_increase_factor": 2}'


def open_zenoh(host: Host, service: Owner) -> None:
    """Answer queries for a service, on a socket of its own and through the manager of this host.

    Raises:
        Refused: The path of the socket does not do.
        Unreachable: The socket cannot be made.
    """
    path = places.check_socket_length(places.service_key_socket(service.name))
    with contextlib.suppress(FileNotFoundError):
        os.unlink(path)  # of one that was killed: the name is ours since the line door is open
    manager = unix_endpoint(places.manager_socket(os.environ.get("RTKIT_MANAGER") or
                                                  places.DEFAULT_MANAGER))  # fmt: skip
    more = {"connect/endpoints": json.dumps([manager]), "connect/retry": _RETRY}
    session = open_listener(unix_endpoint(path), more=more)
    host.at_end(lambda: remove_socket(path))
    key = keys.property_service(os.uname().nodename, service.name)
    desk = Desk(host, service)
    door = PropertyDoor(session, key, desk.take)
    desk.send = door.send
    host.at_end(door.close)


class Desk:
    """Takes queries to the service; knows the listeners behind them.

    Attributes:
        send: Sends an event to a listener.
    """

    def __init__(self, host: Host, service: Owner) -> None:
        self.send: Callable[[str, Event], None] = lambda ear, event: None
        self._host = host
        self._service = service
        self._ears: dict[str, Ear] = {}
        self.room = Room(host.policy, "zenoh", lambda: list(self._ears.values()))
        self._asker = Caller("user")
        self._asker.access = self.room.access

    def take(self, query: Queried) -> None:
        """Take a query, on a thread of the transport: nothing of the user's is called here."""
        most = self.room.limits.size
        if query.payload is not None and len(query.payload) > most:
            query.answer(Answer(f"longer than {most} bytes", "too-large"))
            return
        is_kept = self._service.is_plain(query.target)
        if is_kept and not self._host.has_posted and self._host.lock.acquire(blocking=False):
            try:
                self._service.handle(Ask(query.target, query.payload, query.answer, self._asker))
            finally:
                self._host.lock.release()
            return
        self._host.post(lambda: self._work(query))

    def _work(self, query: Queried) -> None:
        ask = Ask(query.target, query.payload, query.answer, self._asker)
        if not query.ear:
            self._service.handle(ask)
            return
        try:
            ear = self._ear(query.ear)
        except PropertyError as error:
            query.answer(Answer(str(error), error.code))
            return
        self._service.handle(ask._replace(target=_leased(query.target), caller=ear))
        ear.repeat()
        if not ear.is_used:
            self._ears.pop(query.ear, None)

    def _ear(self, id: str) -> Ear:
        if id not in self._ears:
            for gone in [each for each, ear in self._ears.items() if not ear.is_used]:
                del self._ears[gone]
            if len(self._ears) >= self.room.limits.connections:
                raise PropertyError("denied", f"{self.room.limits.connections} are listening")
            self._ears[id] = Ear(self, self._host, id)
        return self._ears[id]


class Ear(Caller):
    """Who listens over zenoh: the queue is here, what is sent to it is not waited for."""

    def __init__(self, desk: Desk, host: Host, id: str) -> None:
        super().__init__("user")
        self.access = desk.room.access
        self._desk = desk
        self._host = host
        self._id = id
        self._listeners: list[Listener] = []
        self._last: Event | None = None

    @property
    def is_used(self) -> bool:
        """Whether it listens to anything."""
        return bool(self._listeners)

    @property
    def listening(self) -> int:
        """How much it listens to."""
        return len(self._listeners)

    def listen(self, listener: Listener) -> None:
        """See `Caller.listen`."""
        self._desk.room.check_listeners(self.listening)
        self._listeners.append(listener)

    def unlisten(self, listener: Listener) -> None:
        """See `Caller.unlisten`."""
        if listener in self._listeners:
            self._listeners.remove(listener)

    def wake(self) -> None:
        """See `Caller.wake`."""
        self._host.mark(self)

    def ready(self, mask: int) -> None:
        """See `Tenant.ready`; it has no socket."""

    def check(self, now: float) -> None:
        """See `Tenant.check`; it has a lease."""

    def flush(self, now: float) -> float | None:
        """See `Tenant.flush`."""
        due: list[float] = []
        for listener in list(self._listeners):
            while (event := listener.take(now)) is not None:
                self._last = event
                self._desk.send(self._id, event)
            if listener.has_ended:
                self._listeners.remove(listener)
            elif listener.pending:
                at = listener.due()
                due += [] if at is None else [at]
        return min(due, default=None)

    def repeat(self) -> None:
        """Send the last event once more: it may have been lost."""
        if self._last is not None and not any(each.pending for each in self._listeners):
            self._desk.send(self._id, self._last)


def _leased(target: str) -> str:
    """Return a request to listen with a lease, for who may go without a word."""
    if "lease=" in target or "remove" in target:
        return target
    return f"{target}{'&' if '?' in target else '?'}lease={LEASE_S:g}"
