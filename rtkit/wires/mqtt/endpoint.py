"""MQTT endpoint of a service: requests that come through a broker, and values that it retains.

The endpoint is open while there is a session with the broker; it opens nothing itself. Who asks is
known to the broker only: what may be set is decided before.
"""

from __future__ import annotations

import itertools
from logging import getLogger

from rtkit.link.deadline import deadline_from_text
from rtkit.property.line import write_named
from rtkit.property.messages import Answer, Payload, PropertyEvent
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.wires.mqtt.address import MqttAddress
from rtkit.wires.mqtt.feed import Feed
from rtkit.wires.mqtt.session import DEADLINE, READY, STATE, Message, MqttSession, name_of, topic_of
from rtkit.wires.query_server import QueryServer
from rtkit.wires.zenoh.queries import EventPosition, Joined, Queried

_MOST_ON_THE_WAY = 256
"""Messages that the broker has not taken, above which no event is sent."""
_MOST_WAITING = 4096
_IDENTITY = "mqtt"


class MqttEndpoint:
    """Service at a broker.

    Args:
        address: Of the topic below which the service is put.

    Raises:
        Refused: The broker does not take user and password, or there are none.
        Unreachable: There is no broker.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        service: PropertyProvider,
        address: MqttAddress,
        timeout_s: float,
    ) -> None:
        self._host = host
        self._root = f"{address.path}/{topic_of(service.name)}"
        self._on_the_way = 0
        self._waiting = 0
        self._count = itertools.count()
        self._query_server = QueryServer(host, service, address.scheme, _IDENTITY)
        self._query_server.send = self._send
        self._query_server.has_room = self._has_room
        state = f"{self._root}/{STATE}"
        self._session = MqttSession(
            address,
            on_message=self._on_message,
            came=lambda: host.post(self._came),
            went=lambda why: host.post(lambda: self._went(why)),
            has_room=lambda: host.post(self._arrived),
            will=state,
        )
        self._feed = Feed(host, service, self._root, self._publish, self._has_room)
        self._state = state
        self._is_ready = False
        self._session.connect(timeout_s)
        host.at_end(lambda: self._session.close(Message(state, "disconnected")))

    # The session

    def _came(self) -> None:
        self._on_the_way = 0
        self._session.subscribe(f"{self._root}/#", has_kept=False)
        self._feed.begin(self._ready)
        if self._is_ready:
            getLogger("rtkit.properties").warning("the broker is back")

    def _ready(self) -> None:
        """All values are there."""
        self._is_ready = True
        self._publish(Message(self._state, READY, is_kept=True))

    def _went(self, why: str) -> None:
        self._feed.end()
        getLogger("rtkit.properties").warning("%s", why)

    def _has_room(self) -> bool:
        return self._on_the_way < _MOST_ON_THE_WAY

    def _arrived(self) -> None:
        was_full = not self._has_room()
        self._on_the_way = max(0, self._on_the_way - 1)
        if was_full:
            self._query_server.resume()
            self._feed.resume()

    def _publish(self, message: Message) -> None:
        self._on_the_way += 1
        self._session.publish(message)

    def _send(self, subscription: str, event: PropertyEvent, at: EventPosition) -> None:
        self._publish(Message(subscription, event.payload, more=(("event", write_named(event)),)))

    # Requests

    def _on_message(self, message: Message) -> None:
        """Take a message; on the thread of the session."""
        topic, _, method = message.topic.rpartition("/")
        rest = topic.removeprefix(self._root).lstrip("/")
        if method in ("get", "set") and rest and not rest.startswith("$"):
            until = deadline_from_text(message.attribute(DEADLINE) or "")
            name, is_get = name_of(rest), method == "get"
            self._host.post(lambda: self._request(message, name, until, is_get=is_get))

    def _request(self, message: Message, name: str, until: float, *, is_get: bool) -> None:
        parameters = message.attribute("parameters")
        target = name if parameters is None else f"{name}?{parameters}"
        payload: Payload | None = None if is_get else message.payload

        def answer(reply: Answer, joined: Joined | None = None, /) -> None:
            self._waiting -= 1
            if not message.reply_to:
                if reply.error:
                    text = "nobody waits for the answer: %s: %s %s"
                    log = getLogger("rtkit.properties")
                    log.warning(text, target, reply.error, reply.payload)
                return
            more = (("code", reply.error),) if reply.error else ()
            self._publish(Message(message.reply_to, reply.payload, mark=message.mark, more=more))

        self._waiting += 1
        if self._waiting > _MOST_WAITING:
            answer(Answer(f"{_MOST_WAITING} requests are not answered", "busy"))
            return
        is_listening = not is_get and name.rpartition(".")[2] == "listen"
        if is_listening and not message.reply_to:
            answer(Answer("events need a response topic", "denied"))
            return
        subscription = message.reply_to if is_listening else ""
        self._query_server.work(Queried(target, payload, answer, subscription, until=until))
