"""Takes queries of transports that keep no connection to a service, and serves who listens so."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

from rtkit.link.properties import LEASE_S, Joined, Place, Queried, group_of
from rtkit.property.codes import PropertyError
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.messages import DONE, Answer, Ask, Caller, Event
from rtkit.serving.ears import Ear, Group
from rtkit.serving.host import Host
from rtkit.serving.owner import Owner
from rtkit.serving.room import Room


class Desk:
    """Takes queries to the service; knows the listeners behind them.

    Attributes:
        send: Sends an event to a listener, or to a group of them.
        has_room: Whether the transport takes an event now.
    """

    def __init__(self, host: Host, service: Owner, door: str, identity: str = "user") -> None:
        self.send: Callable[[str, Event, Place], None] = lambda ear, event, at: None
        self.has_room: Callable[[], bool] = lambda: True
        self._identity = identity
        self._host = host
        self._service = service
        self._ears: dict[str, Ear] = {}
        self._groups: dict[str, Group] = {}
        self.room = Room(host.policy, door, lambda: [*self._ears.values(), *self._groups.values()])
        self._asker = Caller(identity)
        self._asker.access = self.room.access

    def take(self, query: Queried) -> None:
        """Take a query, on a thread of the transport: nothing of the user's is called here."""
        if monotonic() > query.until:
            query.answer(Answer(NOT_BEGUN, "timeout"))
            return
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
        for ear in (*self._ears.values(), *self._groups.values()):
            if ear.has_pending:
                self._host.mark(ear)

    def work(self, query: Queried) -> None:
        """Take a query, on the loop, which may have been held up."""
        if monotonic() > query.until:
            query.answer(Answer(NOT_BEGUN, "timeout"))
            return
        ask = Ask(query.target, query.payload, query.answer, self._asker, until=query.until)
        group = self._groups.get(query.group)
        if not query.ear:
            self._service.handle(ask)
        elif group is not None and group.has_member(query.ear):
            self._serve_member(query, group)
        else:
            try:
                self._serve_one(query, ask)
            except PropertyError as error:
                query.answer(Answer(str(error), error.code))

    def _serve_one(self, query: Queried, ask: Ask) -> None:
        is_new = query.ear not in self._ears
        ear = self._ear(query.ear)
        told: list[Answer] = []
        is_late = False

        def answer(reply: Answer) -> None:
            ear.asked -= 1
            if is_late:
                self._answer_one(query, ear, reply, is_new=is_new)
            else:
                told.append(reply)

        ear.asked += 1
        asked = ask._replace(target=_leased(query.target), caller=ear, answer=answer)
        self._service.handle(asked)
        is_late = True
        if told:
            self._answer_one(query, ear, told[0], is_new=is_new)
        ear.repeat()
        self._let_go(query.ear)

    def _answer_one(self, query: Queried, ear: Ear, reply: Answer, *, is_new: bool) -> None:
        joins = is_new and ear.is_used and not reply.error and self._service.has_groups
        query.answer(reply, self._join(query, ear) if joins else None)
        self._let_go(query.ear)

    def _let_go(self, id: str) -> None:
        """Know one no longer who does not listen."""
        if id in self._ears and not self._ears[id].is_used:
            del self._ears[id]

    def _join(self, query: Queried, ear: Ear) -> Joined | None:
        """Have one who listens be a member of its group; None if it has to stay by itself."""
        if not query.group or query.group != group_of(query.target):
            return None
        group = self._groups.get(query.group)
        if group is None or not group.is_used:
            group = Group(self, self._host, query.group, self._identity)
        if not self._is_heard(query.target, group):
            return None
        self._groups[query.group] = group
        first = ear.first()
        self._service.forget(ear)
        group.flush(monotonic())
        return Joined(first, group.enter(query.ear))

    def _is_heard(self, target: str, group: Group) -> bool:
        """Have a group listen, or listen on; return whether it does."""
        told: list[Answer] = []
        self._service.handle(Ask(_shared(target), "self", told.append, group))
        if told and not told[0].error:
            return True
        if not group.listening:
            self._service.forget(group)  # it is asked elsewhere, and told later
        return False

    def _serve_member(self, query: Queried, group: Group) -> None:
        """Serve a member on, or no longer."""
        ask = Ask(_shared(query.target), query.payload, query.answer, group)
        if "remove" in query.target:
            group.leave(query.ear)
            if group.listening:
                query.answer(DONE)
                return
            ask = ask._replace(target=query.target)
            del self._groups[query.group]
        else:
            ask = ask._replace(answer=lambda reply: self._renewed(query, group, reply))
        self._service.handle(ask)

    def _renewed(self, query: Queried, group: Group, reply: Answer) -> None:
        query.answer(reply, None if reply.error else group.renew(query.ear))

    def _ear(self, id: str) -> Ear:
        if id not in self._ears:
            self._tidy()
            most = self.room.limits.connections
            if len(self._ears) + sum(each.listening for each in self._groups.values()) >= most:
                raise PropertyError("denied", f"{most} are listening")
            self._ears[id] = Ear(self, self._host, id, self._identity)
        return self._ears[id]

    def _tidy(self) -> None:
        for all_of_them in (self._ears, self._groups):
            for gone in [id for id, each in all_of_them.items() if not each.is_used]:
                del all_of_them[gone]


def _shared(target: str) -> str:
    """Return a request to listen for a group: the first value is told to each by itself."""
    name, _, tail = target.partition("?")
    kept = [each for each in tail.split("&") if each and not each.startswith("initial")]
    return _leased(f"{name}?{'&'.join([*kept, 'initial=0'])}")


def _leased(target: str) -> str:
    """Return a request to listen with a lease, for who may go without a word."""
    if "lease=" in target or "remove" in target:
        return target
    return f"{target}{'&' if '?' in target else '?'}lease={LEASE_S:g}"
