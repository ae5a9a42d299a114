"""Connection of a proxy to its owner through an MQTT broker."""

from __future__ import annotations

import threading
import uuid
from math import inf
from time import monotonic
from typing import NamedTuple

from rtkit.errors import Unreachable
from rtkit.link.deadline import deadline_at
from rtkit.property.codes import PropertyError
from rtkit.property.line import read_event
from rtkit.property.messages import Answer, Mark, Payload, PropertyEvent
from rtkit.property.naming import parse_target
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.mqtt.address import MqttAddress
from rtkit.wires.mqtt.session import DEADLINE, READY, STATE, Message, MqttSession, topic_of
from rtkit.wires.provider_connection import (
    ENDED,
    Answering,
    EventHandler,
    LoopInbox,
    ProviderConnection,
    over,
    with_id,
)
from rtkit.wires.zenoh.properties import LEASE_S

_LONGEST_MARK = 20


class _Subscription(NamedTuple):
    target: str
    topic: str
    inbox: LoopInbox
    renewed_at: list[float]
    last: list[Mark]


class MqttConnection(ProviderConnection):
    """Session with a broker, below the topic of a service.

    Args:
        address: With the topic of the service.
        timeout_s: Bound on connecting [s].

    Raises:
        Refused: The broker does not take user and password, or there are none.
        Unreachable: There is no broker, or the service is not there.
    """

    def __init__(self, host: PropertyEventLoop, address: MqttAddress, timeout_s: float) -> None:
        super().__init__(host)
        self._root = address.path
        self._own = f"{self._root}/$to/{uuid.uuid4().hex}"
        self._subscriptions: dict[str, _Subscription] = {}
        self._number = 0
        self._state = ""
        self._is_ready = threading.Event()
        self._session = MqttSession(
            address, on_message=self._on_message, came=lambda: None, went=self._went
        )
        self._session.connect(timeout_s)
        self._session.subscribe(f"{self._root}/{STATE}", has_kept=True)
        self._session.subscribe(f"{self._own}/#", has_kept=False)
        if not self._is_ready.wait(timeout_s):
            self._session.close()
            state = f"its state is {self._state}" if self._state else "nothing is there"
            raise Unreachable(f"no service at {address}: {state}")

    def ask(
        self, target: str, payload: Payload | None, id: str, answer: Answering, until: float = inf
    ) -> None:
        """See `ProviderConnection.ask`."""
        self._request(with_id(target, id), payload, f"{self._own}/0", answer, until)

    def has_room(self, name: str) -> bool:
        """See `ProviderConnection.has_room`: each listening has a topic of its own."""
        return name not in self._subscriptions

    def listen(self, name: str, options: str, on_event: EventHandler, answer: Answering) -> None:
        """See `ProviderConnection.listen`."""
        self._number += 1
        more = f"{options}&lease={LEASE_S:g}" if options else f"lease={LEASE_S:g}"
        target = f"{name}.listen".lstrip(".") + f"?{more}"
        topic = f"{self._own}/{self._number}"
        subscription = _Subscription(
            target, topic, LoopInbox(self._host, options, on_event), [monotonic()], []
        )
        self._subscriptions[name] = subscription

        def answered(reply: Answer) -> None:
            if reply.error:
                self._subscriptions.pop(name, None)
            answer(reply)

        self._request(target, "self", topic, answered)

    def leave(self, name: str) -> None:
        """See `ProviderConnection.leave`."""
        subscription = self._subscriptions.pop(name, None)
        if subscription is not None:
            target = f"{subscription.target.partition('?')[0]}?remove"
            self._request(target, "self", subscription.topic, lambda reply: None)

    def check(self, now: float) -> None:
        """See `ProviderConnection.check`: renew leases; the broker reports the owner."""
        for name, subscription in self._subscriptions.items():
            if now - subscription.renewed_at[0] > LEASE_S / 3:
                subscription.renewed_at[0] = now
                self._request(
                    subscription.target,
                    "self",
                    subscription.topic,
                    self._renewed(name, subscription),
                )

    # Its own

    def _release(self) -> None:
        self._subscriptions.clear()
        self._session.close()

    def _renewed(self, name: str, subscription: _Subscription) -> Answering:
        def renewed(reply: Answer) -> None:
            last = over(name, reply)
            if last is not None and self._subscriptions.get(name) is subscription:
                del self._subscriptions[name]
                subscription.inbox.put(last)

        return renewed

    def _request(
        self,
        target: str,
        payload: Payload | None,
        reply_to: str,
        answer: Answering,
        until: float = inf,
    ) -> None:
        if not self._is_open:
            answer(ENDED)
            return
        try:
            name = parse_target(target).name
        except PropertyError as error:
            answer(Answer(str(error), error.code))
            return
        mark = str(self._expect(answer)).encode()
        _, is_given, parameters = target.partition("?")
        topic = f"{self._root}/{topic_of(name)}/{'get' if payload is None else 'set'}"
        more = (("parameters", parameters),) if is_given else ()
        if payload is not None and until < inf:
            more = (*more, (DEADLINE, deadline_at(until)))
        self._session.publish(
            Message(topic, "" if payload is None else payload, reply_to, mark, more)
        )

    def _on_message(self, message: Message) -> None:
        """Take a message; on the thread of the session."""
        if message.topic == f"{self._root}/{STATE}":
            self._state = str(message.payload)
            if self._state == READY:
                self._is_ready.set()
            elif self._is_ready.is_set():
                self._went(f"the state of the service is {self._state}")
            return
        attributes = message.attribute("event")
        if attributes is None:
            reply = Answer(message.payload, message.attribute("code") or "")
            if reply.error and isinstance(reply.payload, bytes):
                reply = Answer(reply.payload.decode("utf-8", "replace"), reply.error)
            self._host.post(lambda: self._answered(message.mark, reply))
            return
        head, _, name = attributes.partition(";name=")
        event = read_event(name, message.payload, head)
        self._host.post(lambda: self._take(message.topic, event))

    def _answered(self, mark: bytes, reply: Answer) -> None:
        if mark.isdigit() and len(mark) < _LONGEST_MARK:  # else it is not one of ours
            self._answer(int(mark), reply)

    def _take(self, topic: str, event: PropertyEvent) -> None:
        for subscription in self._subscriptions.values():
            # Else it was sent again, in case it had been lost.
            if subscription.topic == topic and subscription.last != [event.mark]:
                subscription.last[:] = [event.mark]
                subscription.inbox.put(event)

    def _went(self, why: str) -> None:
        if self._is_ready.is_set():
            self._host.post(lambda: self._fail(why))
