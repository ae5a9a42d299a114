"""Takes queries of transports that keep no connection to a service, and serves who listens so."""

from __future__ import annotations

from collections.abc import Callable

from rtkit.link.properties import LEASE_S, Queried
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, Ask, Caller, Event
from rtkit.serving.hearer import Hearer
from rtkit.serving.host import Host
from rtkit.serving.owner import Owner
from rtkit.serving.room import Room


class Desk:
    """Takes queries to the service; knows the listeners behind them.

    Attributes:
        send: Sends an event to a listener.
        has_room: Whether the transport takes an event now.
    """

    def __init__(self, host: Host, service: Owner, door: str, identity: str = "user") -> None:
        self.send: Callable[[str, Event], None] = lambda ear, event: None
        self.has_room: Callable[[], bool] = lambda: True
        self._identity = identity
        self._host = host
        self._service = service
        self._ears: dict[str, Ear] = {}
        self.room = Room(host.policy, door, lambda: list(self._ears.values()))
        self._asker = Caller(identity)
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
        self._host.post(lambda: self.work(query))

    def resume(self) -> None:
        """Send what had to wait: there is room again."""
        for ear in self._ears.values():
            if ear.has_pending:
                self._host.mark(ear)

    def work(self, query: Queried) -> None:
        """Take a query, on the loop."""
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
            self._ears[id] = Ear(self, self._host, id, self._identity)
        return self._ears[id]


class Ear(Hearer):
    """Who listens: the queue is here, what is sent to it is not waited for."""

    def __init__(self, desk: Desk, host: Host, id: str, identity: str) -> None:
        super().__init__(desk.room, identity)
        self._desk = desk
        self._host = host
        self._id = id
        self._last: Event | None = None

    @property
    def is_used(self) -> bool:
        """Whether it listens to anything."""
        return bool(self._listeners)

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
            while self._desk.has_room() and (event := listener.take(now)) is not None:
                self._last = event
                self._desk.send(self._id, event)
            if listener.has_ended and not listener.pending:
                self._listeners.remove(listener)
            elif listener.pending and self._desk.has_room():
                at = listener.due()
                due += [] if at is None else [at]
        return min(due, default=None)

    def repeat(self) -> None:
        """Send the last event once more: it may have been lost."""
        if self._last is not None and not self.has_pending:
            self._desk.send(self._id, self._last)


def _leased(target: str) -> str:
    """Return a request to listen with a lease, for who may go without a word."""
    if "lease=" in target or "remove" in target:
        return target
    return f"{target}{'&' if '?' in target else '?'}lease={LEASE_S:g}"
