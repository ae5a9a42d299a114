"""Starts a mosquitto broker for a test: on a free port of this host, with one user."""

from __future__ import annotations

import shutil
import socket
import subprocess
import threading
from collections.abc import Callable
from pathlib import Path

from paho.mqtt.client import Client, MQTTMessage, MQTTv5
from paho.mqtt.enums import CallbackAPIVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

USER, PASSWORD = "robot", "sesame"
MOSQUITTO = shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin:/usr/bin:/usr/local/bin")
PASSWD = shutil.which("mosquitto_passwd", path="/usr/bin:/usr/local/bin:/usr/sbin")


_TLS = """\
cafile {0}/ca.crt
certfile {0}/own.crt
keyfile {0}/own.key
crlfile {0}/revoked.crl
require_certificate true
use_identity_as_username true
"""


class Mosquitto:
    """A broker; it can be ended and begun again, and forgets everything by that.

    Args:
        keys: Folder of keys, for mutual TLS; names of certificates are those of users.
    """

    def __init__(self, folder: Path, keys: str = "") -> None:
        self._scheme = "mqtts" if keys else "mqtt"
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = int(probe.getsockname()[1])
        passwords = folder / "passwords"
        passwords.touch(mode=0o600)
        assert PASSWD is not None
        subprocess.run([PASSWD, "-b", str(passwords), USER, PASSWORD], check=True)
        self._config = folder / "mosquitto.conf"
        self._config.write_text(
            f"listener {self.port} 127.0.0.1\n"
            "allow_anonymous false\n"
            f"password_file {passwords}\n"
            "user root\n"
            "max_queued_messages 0\n"
            "set_tcp_nodelay true\n" + (_TLS.format(keys) if keys else "")
        )
        self._process: subprocess.Popen[str] | None = None
        self.start()

    def start(self) -> None:
        """Begin, and wait until it listens."""
        assert MOSQUITTO is not None
        self._process = subprocess.Popen(
            [MOSQUITTO, "-c", str(self._config)], stderr=subprocess.PIPE, text=True
        )
        assert self._process.stderr is not None
        told = []
        for line in self._process.stderr:
            told.append(line)
            if " running" in line:
                return
        raise AssertionError("".join(told))

    def stop(self) -> None:
        """End, as when it crashes."""
        process = self._process
        if process is not None:
            process.kill()
            process.communicate()
            self._process = None

    def address(self, topic: str) -> str:
        """Return the address of a topic."""
        return f"{self._scheme}:{USER}@localhost:{self.port}/{topic}"


class Stranger:
    """A client of another make, that knows only MQTT: hears all there is below a topic."""

    def __init__(self, port: int, topic: str) -> None:
        self.known: dict[str, bytes] = {}
        self.replies: list[tuple[bytes, dict[str, str], bytes]] = []
        self._arrived = threading.Condition()
        self._client = Client(CallbackAPIVersion.VERSION2, protocol=MQTTv5)
        self._client.username_pw_set(USER, PASSWORD)
        self._client.reconnect_delay_set(1, 1)
        self._client.on_message = self._take
        self._client.on_connect = lambda client, *_: client.subscribe([(topic, 1), ("mine/#", 1)])
        self._client.connect("127.0.0.1", port)
        self._client.loop_start()

    def _take(self, client: Client, data: object, message: MQTTMessage) -> None:
        with self._arrived:
            if message.topic.startswith("mine/"):
                more = dict(getattr(message.properties, "UserProperty", ()))
                mark = getattr(message.properties, "CorrelationData", b"")
                self.replies.append((bytes(message.payload), more, mark))
            elif message.payload:
                self.known[message.topic] = bytes(message.payload)
            else:
                self.known.pop(message.topic, None)
            self._arrived.notify_all()

    def awaits(self, holds: Callable[[], bool]) -> None:
        """Wait until something holds of what was heard."""
        with self._arrived:
            assert self._arrived.wait_for(holds, 30.0), (self.known, self.replies)

    def publish(self, topic: str, payload: str | bytes, mark: bytes = b"") -> None:
        """Publish; with a mark, a reply is wished for."""
        properties = Properties(PacketTypes.PUBLISH)
        if mark:
            properties.ResponseTopic, properties.CorrelationData = "mine/reply", mark
        self._client.publish(topic, payload, 1, properties=properties)

    def close(self) -> None:
        """Leave."""
        self._client.disconnect()
        self._client.loop_stop()
