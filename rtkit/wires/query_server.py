"""Query server: serves requests and listeners of transports that keep no connection."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

from rtkit.property.codes import PropertyError
from rtkit.property.exchange import NOT_BEGUN
from rtkit.property.messages import DONE, Answer, PropertyEvent
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.subscription import leased
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.serving.quota import EndpointQuota
from rtkit.wires.subscribers import SharedSubscription, Subscriber
from rtkit.wires.zenoh.queries import EventPosition, Joined, Queried, group_of


class QueryServer:
    """Takes queries to the service; knows the listeners behind them.

    Attributes:
        send: Sends an event to a listener, or to a group of them.
        has_room: Whether the transport takes an event now.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        service: PropertyProvider,
        endpoint: str,
        identity: str = "user",
    ) -> None:
        self.send: Callable[[str, PropertyEvent, EventPosition], None] = (
            lambda subscription, event, at: None
        )
        self.has_room: Callable[[], bool] = lambda: True
        self._identity = identity
        self._host = host
        self._service = service
        self._subscriptions: dict[str, Subscriber] = {}
        self._groups: dict[str, SharedSubscription] = {}
        self.quota = EndpointQuota(
            host.policy, endpoint, lambda: [*self._subscriptions.values(), *self._groups.values()]
        )
        self._asker = Requester(identity)
        self._asker.access = self.quota.access

    def take(self, query: Queried) -> None:
        """Take a query, on a thread of the transport: nothing of the user's is called here."""
        if monotonic() > query.until:
            query.answer(Answer(NOT_BEGUN, "timeout"))
            return
        most = self.quota.limits.size
        if query.payload is not None and len(query.payload) > most:
            query.answer(Answer(f"longer than {most} bytes", "too-large"))
            return
        is_kept = self._service.is_plain(query.target)
        if is_kept and not self._host.has_posted and self._host.lock.acquire(blocking=False):
            try:
                self._service.handle(
                    PropertyRequest(query.target, query.payload, query.answer, self._asker)
                )
            finally:
                self._host.lock.release()
            return
        self._host.post(lambda: self.work(query))

    def resume(self) -> None:
        """Send what had to wait: the receiver takes messages again."""
        for subscription in (*self._subscriptions.values(), *self._groups.values()):
            if subscription.has_pending:
                self._host.mark(subscription)

    def work(self, query: Queried) -> None:
        """Take a query, on the loop, which may have been held up."""
        if monotonic() > query.until:
            query.answer(Answer(NOT_BEGUN, "timeout"))
            return
        ask = PropertyRequest(
            query.target, query.payload, query.answer, self._asker, until=query.until
        )
        group = self._groups.get(query.group)
        if not query.subscription:
            self._service.handle(ask)
        elif group is not None and group.has_member(query.subscription):
            self._serve_member(query, group)
        else:
            try:
                self._serve_one(query, ask)
            except PropertyError as error:
                query.answer(Answer(str(error), error.code))

    def _serve_one(self, query: Queried, ask: PropertyRequest) -> None:
        is_new = query.subscription not in self._subscriptions
        subscription = self._subscription(query.subscription)
        answers: list[Answer] = []
        is_late = False

        def answer(reply: Answer) -> None:
            subscription.asked -= 1
            if is_late:
                self._answer_one(query, subscription, reply, is_new=is_new)
            else:
                answers.append(reply)

        subscription.asked += 1
        asked = ask._replace(target=leased(query.target), caller=subscription, answer=answer)
        self._service.handle(asked)
        is_late = True
        if answers:
            self._answer_one(query, subscription, answers[0], is_new=is_new)
        subscription.repeat()
        self._let_go(query.subscription)

    def _answer_one(
        self, query: Queried, subscription: Subscriber, reply: Answer, *, is_new: bool
    ) -> None:
        joins = is_new and subscription.is_used and not reply.error and self._service.has_groups
        query.answer(reply, self._join(query, subscription) if joins else None)
        self._let_go(query.subscription)

    def _let_go(self, id: str) -> None:
        """Know one no longer who does not listen."""
        if id in self._subscriptions and not self._subscriptions[id].is_used:
            del self._subscriptions[id]

    def _join(self, query: Queried, subscription: Subscriber) -> Joined | None:
        """Make a subscriber a member of its group; None if it has to stay by itself."""
        if not query.group or query.group != group_of(query.target):
            return None
        group = self._groups.get(query.group)
        if group is None or not group.is_used:
            group = SharedSubscription(self, self._host, query.group, self._identity)
        if not self._is_listening(query.target, group):
            return None
        self._groups[query.group] = group
        first = subscription.first()
        self._service.forget(subscription)
        group.flush(monotonic())
        return Joined(first, group.enter(query.subscription))

    def _is_listening(self, target: str, group: SharedSubscription) -> bool:
        """Make a group listen, or listen on; return whether it does."""
        answers: list[Answer] = []
        self._service.handle(PropertyRequest(_shared(target), "self", answers.append, group))
        if answers and not answers[0].error:
            return True
        if not group.listening:
            self._service.forget(group)  # it is asked elsewhere, and told later
        return False

    def _serve_member(self, query: Queried, group: SharedSubscription) -> None:
        """Serve a member on, or no longer."""
        ask = PropertyRequest(_shared(query.target), query.payload, query.answer, group)
        if "remove" in query.target:
            group.leave(query.subscription)
            if group.listening:
                query.answer(DONE)
                return
            ask = ask._replace(target=query.target)
            del self._groups[query.group]
        else:
            ask = ask._replace(answer=lambda reply: self._renewed(query, group, reply))
        self._service.handle(ask)

    def _renewed(self, query: Queried, group: SharedSubscription, reply: Answer) -> None:
        query.answer(reply, None if reply.error else group.renew(query.subscription))

    def _subscription(self, id: str) -> Subscriber:
        if id not in self._subscriptions:
            self._tidy()
            most = self.quota.limits.connections
            if (
                len(self._subscriptions) + sum(each.listening for each in self._groups.values())
                >= most
            ):
                raise PropertyError("denied", f"{most} are listening")
            self._subscriptions[id] = Subscriber(self, self._host, id, self._identity)
        return self._subscriptions[id]

    def _tidy(self) -> None:
        for all_of_them in (self._subscriptions, self._groups):
            for gone in [id for id, each in all_of_them.items() if not each.is_used]:
                del all_of_them[gone]


def _shared(target: str) -> str:
    """Return a request to listen for a group: each member gets the first value by itself."""
    name, _, tail = target.partition("?")
    kept = [each for each in tail.split("&") if each and not each.startswith("initial")]
    return leased(f"{name}?{'&'.join([*kept, 'initial=0'])}")
