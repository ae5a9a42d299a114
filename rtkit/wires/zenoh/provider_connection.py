"""Connection of a proxy to its owner over zenoh: queries, and a key for each subscription."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from math import inf
from time import monotonic

import zenoh

from rtkit.errors import Unreachable
from rtkit.link.deadline import deadline_to_bytes
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.property.subscription import listen_target
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.provider_connection import (
    ENDED,
    STATUS,
    Answering,
    EventHandler,
    LeasedConnection,
    LeasedSubscription,
    LoopInbox,
    with_id,
)
from rtkit.wires.zenoh.queries import (
    EventProgress,
    answer_of,
    event_of,
    for_subscriber,
    selector_of,
    subscriber_key,
)

_REQUEST_S = 3600.0
"""Time-out of an answer [s]; the keepalive detects a dead peer."""
_LEAST_S = 1e-3
_PROBE_S = 2.0
_PROBE_EVERY_S = 1.0
_NOBODY = "nobody answers for it"


class ZenohConnection(LeasedConnection):
    """Session to the owner, used by nobody else.

    Args:
        service_key: Of the owner.
        why: Tells why nobody answers.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        session: zenoh.Session,
        service_key: str,
        why: Callable[[], str] = lambda: _NOBODY,
    ) -> None:
        super().__init__(host)
        self._why = why
        self._session = session
        self._key = service_key
        self._probed_at = monotonic()
        self._is_probing = False
        self._is_silent = False

    def ask(
        self, target: str, payload: Payload | None, id: str, answer: Answering, until: float = inf
    ) -> None:
        """See `ProviderConnection.ask`."""
        wait_s = min(_REQUEST_S, max(until - monotonic(), _LEAST_S))
        self._query(with_id(target, id), payload, "", wait_s, answer)

    def check(self, now: float) -> None:
        """See `ProviderConnection.check`: ask for a sign of life, and renew what has a lease."""
        super().check(now)
        if not self._is_probing and now - self._probed_at > _PROBE_EVERY_S:
            self._is_probing, self._probed_at = True, now
            self._query(STATUS, None, "", _PROBE_S, self._probed)

    # Its own

    def _subscribe(self, name: str, options: str, on_event: EventHandler) -> LeasedSubscription:
        id = uuid.uuid4().hex
        inbox = LoopInbox(self._host, options, lambda event: self._on_event(id, on_event, event))
        handler = zenoh.handlers.Callback(_receiver(inbox), indirect=False)
        subscriber = self._session.declare_subscriber(subscriber_key(self._key, id), handler)
        return LeasedSubscription(listen_target(name, options), id, on_event, subscriber.undeclare)

    def _ask_about(
        self, subscription: LeasedSubscription, target: str, answer: Answering, *, is_new: bool
    ) -> None:
        wait_s = _REQUEST_S if is_new else _PROBE_S
        self._query(target, "self", subscription.address, wait_s, answer)

    def _probed(self, reply: Answer) -> None:
        self._is_probing = False
        if reply.error in ("timeout", "no-service") and self._is_open:
            self._is_silent = True
            self._fail(str(reply.payload), reply.error)

    def _query(
        self,
        target: str,
        payload: Payload | None,
        subscription: str,
        timeout_s: float,
        answer: Answering,
    ) -> None:
        """Ask; the answer comes on the loop."""
        if not self._is_open:
            answer(ENDED)
            return
        try:
            selector = selector_of(self._key, target)
        except PropertyError as error:
            answer(Answer(str(error), error.code))
            return
        number = self._expect(answer)
        replies: list[Answer] = []

        def receive(reply: zenoh.Reply) -> None:
            try:
                replies.append(answer_of(reply, timeout_s))
            except Unreachable as error:
                replies.append(Answer(str(error), "timeout"))

        def ended() -> None:
            self._host.post(lambda: self._answer(number, self._first(replies)))

        self._session.get(
            for_subscriber(selector, subscription) if subscription else selector,
            payload=payload,
            attachment=None if payload is None or subscription else deadline_to_bytes(timeout_s),
            timeout=timeout_s,
            handler=zenoh.handlers.Callback(receive, ended, indirect=False),
            consolidation=zenoh.ConsolidationMode.NONE,
        )

    def _first(self, replies: list[Answer]) -> Answer:
        return replies[0] if replies else Answer(self._why(), "no-service")

    def _on_event(self, id: str, on_event: EventHandler, event: PropertyEvent) -> None:
        if any(each.address == id for each in self._subscriptions.values()):
            on_event(event)

    def _release(self) -> None:
        super()._release()
        if self._is_silent:
            # It waits for the far side, which is not there: not on the loop.
            self._begin_thread(self._session.close, name="closing")
        else:
            self._session.close()  # type: ignore[no-untyped-call]


def _receiver(inbox: LoopInbox) -> Callable[[zenoh.Sample], None]:
    known = EventProgress()

    def receive(sample: zenoh.Sample) -> None:
        """Take what arrived; on a thread of the transport."""
        event, at = event_of(sample)
        lost = None if at is None else known.lost(at)
        if event is not None and lost is not None:  # else it was sent again
            inbox.put(event, lost)

    return receive
