"""Client of one property service over zenoh: asks and listens."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import zenoh

from rtkit.errors import Unreachable
from rtkit.link.deadline import deadline_to_bytes
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer, Payload
from rtkit.wires.zenoh.properties import (
    Joined,
    answer_of,
    event_of,
    for_subscriber,
    selector_of,
    subscriber_key,
)
from rtkit.wires.zenoh.subscriptions import SharedSubscriptions, ZenohSubscription

_SHORT = 256
_MOST_KNOWN = 4096
"""Targets of which a client remembers the keys, and how long they may be."""


class ZenohClient:
    """Asks one service over a session that others may use too.

    Args:
        timeout_s: Bound on each request [s].
    """

    def __init__(self, session: zenoh.Session, service_key: str, timeout_s: float) -> None:
        self._session = session
        self._key = service_key
        self._timeout_s = timeout_s
        self._selectors: dict[str, str] = {}
        self._groups = SharedSubscriptions(session, service_key)

    def ask(self, target: str, payload: Payload | None = None) -> Answer:
        """GET, or SET, and wait for the reply.

        Raises:
            Unreachable: No reply in time, or nobody serves it.
        """
        selector = self._selectors.get(target)
        if selector is None:
            try:
                selector = selector_of(self._key, target)
            except PropertyError as error:
                return Answer(str(error), error.code)  # no key can be made of it
            if len(target) < _SHORT and len(self._selectors) < _MOST_KNOWN:
                self._selectors[target] = selector
        return answer_of(self._reply(selector, payload), self._timeout_s)

    def ask_to_listen(self, target: str, subscription: str, group: str) -> Joined | None:
        """Serve a listener, renew it or end it; return its state in its group.

        Raises:
            PropertyError: As the service answers.
            Unreachable: No reply in time, or nobody serves it.
        """
        reply = self._reply(
            for_subscriber(selector_of(self._key, target), subscription, group), "self"
        )
        answer_of(reply, self._timeout_s).value()
        if reply.ok is None or reply.ok.attachment is None:
            return None
        event, at = event_of(reply.ok)
        return None if at is None else Joined(event, at)

    def _reply(self, selector: str, payload: Payload | None) -> zenoh.Reply:
        try:
            replies = self._session.get(
                selector,
                payload=payload,
                attachment=None if payload is None else deadline_to_bytes(self._timeout_s),
                timeout=self._timeout_s,
                handler=zenoh.handlers.FifoChannel(16),
                consolidation=zenoh.ConsolidationMode.NONE,
            )
            for reply in replies:
                return reply
        except zenoh.ZError as error:  # it was closed here
            raise Unreachable(f"the connection has ended: {error}") from error
        raise Unreachable("nobody answers for it")

    @contextmanager
    def listen(self, target: str) -> Iterator[ZenohSubscription]:
        """Listen to ``P`` or ``P?queue=…`` for as long as the context lasts.

        Raises:
            PropertyError: As the service answers.
        """
        name, mark, tail = target.partition("?")
        subscription = ZenohSubscription(self, f"{name}.listen{mark}{tail}", tail)
        handler = zenoh.handlers.Callback(subscription.receive, indirect=False)
        subscriber = self._session.declare_subscriber(
            subscriber_key(self._key, subscription.id), handler
        )
        self._groups.enter(subscription)
        try:
            subscription.renew()
            yield subscription
        finally:
            self._groups.leave(subscription)
            subscriber.undeclare()  # type: ignore[no-untyped-call]
            subscription.leave()
