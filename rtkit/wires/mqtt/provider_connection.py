"""Connection of a proxy to its owner through an MQTT broker."""

from __future__ import annotations

import threading
import uuid
from math import inf

from rtkit.errors import Unreachable
from rtkit.link.deadline import deadline_at
from rtkit.property.codes import PropertyError
from rtkit.property.line import read_named
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.property.naming import parse_target
from rtkit.property.subscription import leased, listen_target
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.mqtt.address import MqttAddress
from rtkit.wires.mqtt.session import DEADLINE, READY, STATE, Message, MqttSession, topic_of
from rtkit.wires.provider_connection import (
    ENDED,
    Answering,
    EventHandler,
    LeasedConnection,
    LeasedSubscription,
    LoopInbox,
    with_id,
)

_LONGEST_MARK = 20


class MqttConnection(LeasedConnection):
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

    # Its own

    def _subscribe(self, name: str, options: str, on_event: EventHandler) -> LeasedSubscription:
        self._number += 1
        target = leased(listen_target(name, options))
        inbox = LoopInbox(self._host, options, on_event)
        return LeasedSubscription(target, f"{self._own}/{self._number}", inbox.put)

    def _ask_about(
        self, subscription: LeasedSubscription, target: str, answer: Answering, *, is_new: bool
    ) -> None:
        self._request(target, "self", subscription.address, answer)

    def _release(self) -> None:
        super()._release()
        self._session.close()

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
        event = read_named(message.payload, attributes)
        self._host.post(lambda: self._take(message.topic, event))

    def _answered(self, mark: bytes, reply: Answer) -> None:
        if mark.isdigit() and len(mark) < _LONGEST_MARK:  # else it is not one of ours
            self._answer(int(mark), reply)

    def _take(self, topic: str, event: PropertyEvent) -> None:
        for subscription in self._subscriptions.values():
            # Else it was sent again, in case it had been lost.
            if subscription.address == topic and subscription.last != event.mark:
                subscription.last = event.mark
                subscription.take(event)

    def _went(self, why: str) -> None:
        if self._is_ready.is_set():
            self._host.post(lambda: self._fail(why))
