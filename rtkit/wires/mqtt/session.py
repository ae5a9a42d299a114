"""MQTT 5: topics of properties, and a session with a broker.

``BASE/SERVICE/arm/angle`` holds the value of ``arm.angle``. What is published to ``…/set`` and
``…/get`` is a request; its reply goes to the response topic with the correlation data. The user
properties are ``parameters`` of a request, ``code`` of an error, ``event`` of an event.
"""

from __future__ import annotations

import os
import socket
import ssl
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.errors import Refused, Unreachable
from rtkit.extras import how_to_get
from rtkit.keys.tls import Trust, peer_of
from rtkit.property.messages import Payload, text_or_bytes
from rtkit.wires.mqtt.address import MqttAddress

if TYPE_CHECKING:
    from paho.mqtt.client import Client, MQTTMessage
    from paho.mqtt.reasoncodes import ReasonCode

PASSWORD = "RTKIT_MQTT_PASSWORD"
"""Variable of the environment that holds the password at the broker."""
DEADLINE = "deadline"
"""User property: when a request is given up, as `rtkit.link.deadline` writes it."""
STATE, READY, LOST = "$state", "ready", "lost"
_KEEPALIVE_S = 10
_LATE = "no answer within"


def topic_of(name: str) -> str:
    """Return the levels of a topic that stand for a name in canonical spelling."""
    return name.replace("+", "%2B").replace(".", "/")


def name_of(topic: str) -> str:
    """Return the name that levels of a topic stand for."""
    return topic.replace("/", ".")


class Message(NamedTuple):
    """Message to publish.

    Attributes:
        payload: Characters are marked as such.
        reply_to: Response topic, empty for none.
        mark: Correlation data.
        more: User properties.
        is_kept: The broker retains it for who subscribes later.
    """

    topic: str
    payload: Payload
    reply_to: str = ""
    mark: bytes = b""
    more: tuple[tuple[str, str], ...] = ()
    is_kept: bool = False

    def attribute(self, key: str) -> str | None:
        """Return a user property."""
        return dict(self.more).get(key)


class _ClosingTls(ssl.SSLSocket):
    """Socket that is closed by a handshake that fails: paho forgets to."""

    def do_handshake(self, block: bool = False) -> None:
        """See `ssl.SSLSocket.do_handshake`."""
        try:
            super().do_handshake(block)
        except OSError:
            self.close()
            raise


class MqttSession:
    """Session with a broker; it reconnects whenever it ends until it is closed.

    Args:
        will: Topic of the state, which the broker sets to `LOST` when this is not heard of.
        on_message: Called with each message, on a thread of the session.
        came: Called when it is connected, also again.
        went: Called with why it is not, likewise.
        has_room: Called when what was published has arrived at the broker.

    Raises:
        Refused: There is no password, or no paho-mqtt; the keys cannot be used.
        NotFound: There are no keys.
    """

    def __init__(
        self,
        address: MqttAddress,
        *,
        on_message: Callable[[Message], None],
        came: Callable[[], None],
        went: Callable[[str], None],
        has_room: Callable[[], None] = lambda: None,
        will: str = "",
    ) -> None:
        try:
            from paho.mqtt.client import Client, MQTTv5
            from paho.mqtt.enums import CallbackAPIVersion
        except ImportError as error:
            raise Refused(f"MQTT needs paho-mqtt: {how_to_get('mqtt')}") from error
        password = os.environ.get(PASSWORD)
        self._trust = Trust(is_server=False) if address.scheme == "mqtts" else None
        if not password and self._trust is None:
            raise Refused(f"no password for {address.user} at the broker: set {PASSWORD}")
        self.address = address
        self._on_message, self._came, self._went, self._has_room = on_message, came, went, has_room
        self._first = threading.Event()
        self._refusal = ""
        self._client: Client = Client(CallbackAPIVersion.VERSION2, protocol=MQTTv5)
        self._client.username_pw_set(address.user, password)
        if self._trust is not None:
            context = self._trust.context()
            context.sslsocket_class = _ClosingTls
            self._client.tls_set_context(context)
        self._client.reconnect_delay_set(1, 5)
        self._client.on_socket_open = _hurry
        self._client.on_connect = lambda client, data, flags, code, more: self._connected(code)
        self._client.on_disconnect = lambda client, data, flags, code, more: self._left(code)
        self._client.on_message = lambda client, data, message: self._received(message)
        self._client.on_publish = lambda *_: self._has_room()
        if will:
            self._client.will_set(will, LOST, qos=1, retain=True)

    def connect(self, timeout_s: float) -> None:
        """Connect for the first time.

        Raises:
            Unreachable: Nobody listens there.
            Refused: The broker does not take user and password.
        """
        where = f"{self.address.host}:{self.address.port}"
        self._client.connect_timeout = timeout_s
        try:
            self._client.connect(self.address.host, self.address.port, _KEEPALIVE_S)
        except ssl.SSLCertVerificationError as error:
            why = f"the broker at {where} is not trusted: {error.verify_message}"
            raise Refused(why) from None
        except OSError as error:
            raise Unreachable(f"cannot reach {where}: {error.strerror or error}") from error
        self._client.loop_start()
        if not self._first.wait(timeout_s):
            self.close()
            raise Unreachable(f"{_LATE} {timeout_s:g} s: {where}")
        if self._refusal:
            self.close()
            raise Refused(f"the broker at {where} refuses {self.address.user}: {self._refusal}")

    def publish(self, message: Message) -> None:
        """Publish, at least once; nobody is waited for."""
        from paho.mqtt.packettypes import PacketTypes
        from paho.mqtt.properties import Properties

        properties = Properties(PacketTypes.PUBLISH)  # type: ignore[no-untyped-call]
        payload = message.payload
        if isinstance(payload, str):
            try:
                payload = payload.encode()
                properties.PayloadFormatIndicator = 1
            except UnicodeEncodeError:
                payload = message.payload.encode("utf-8", "surrogateescape")  # type: ignore[union-attr]
        if message.reply_to:
            properties.ResponseTopic = message.reply_to
        if message.mark:
            properties.CorrelationData = message.mark
        if message.more:
            properties.UserProperty = list(message.more)
        self._client.publish(message.topic, payload, 1, message.is_kept, properties)

    def subscribe(self, topic: str, *, has_kept: bool) -> None:
        """Subscribe to what others publish.

        Args:
            topic: A pattern.
            has_kept: Also what was published before and is retained.
        """
        from paho.mqtt.subscribeoptions import SubscribeOptions

        options = SubscribeOptions(1, noLocal=True, retainHandling=0 if has_kept else 2)
        self._client.subscribe(topic, options=options)

    def close(self, last: Message | None = None) -> None:
        """End the session; the last word is retained."""
        if last is not None and self._client.is_connected():
            publishing = self._client.publish(last.topic, last.payload, 1, retain=True)
            publishing.wait_for_publish(1.0)
        self._client.disconnect()
        self._client.loop_stop()

    # On the thread of the session

    def _connected(self, code: ReasonCode) -> None:
        is_first = not self._first.is_set()
        why = f"the broker refuses: {code}" if code.is_failure else self._distrust()
        if why:
            self._refusal = str(code) if code.is_failure else why
            self._went(why)
        else:
            self._refusal = ""
            self._came()
        if is_first:
            self._first.set()

    def _distrust(self) -> str:
        """Return why the broker's certificate does not do, and leave; empty if it does."""
        end: Any = self._client.socket()
        if self._trust is None or end is None:
            return ""
        why = self._trust.refusal(peer_of(end), is_new=True)
        if why:
            self._client.disconnect()
        return why

    def _left(self, code: ReasonCode) -> None:
        if self._trust is not None and not self._first.is_set():
            self._refusal = "it hangs up: the certificate of this user (rtkeys show) may not do"
            self._first.set()
        if code.is_failure:  # else we asked for it
            self._went(f"the broker has gone: {code}")

    def _received(self, message: MQTTMessage) -> None:
        given = message.properties
        raw = bytes(message.payload)
        is_text = getattr(given, "PayloadFormatIndicator", 0) == 1  # not everybody marks it
        self._on_message(
            Message(
                message.topic,
                raw.decode("utf-8", "surrogateescape") if is_text else text_or_bytes(raw),
                getattr(given, "ResponseTopic", ""),
                getattr(given, "CorrelationData", b""),
                tuple(getattr(given, "UserProperty", ())),
            )
        )


def _hurry(client: Client, data: object, end: object) -> None:
    """Send small messages at once: others wait for them."""
    assert isinstance(end, socket.socket)
    end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
