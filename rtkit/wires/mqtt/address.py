"""Addresses of topics at a broker, ``mqtt:USER@HOST/TOPIC``, ``mqtts:`` behind TLS."""

from __future__ import annotations

from typing import NamedTuple

from rtkit.errors import Malformed

_PORTS = {"mqtt": 1883, "mqtts": 8883}


class MqttAddress(NamedTuple):
    """Address of a topic at a broker.

    Attributes:
        path: The topic below which everything is.
        scheme: ``mqtts`` where the broker is asked for a certificate, and shown one.
    """

    user: str
    host: str
    port: int
    path: str
    scheme: str = "mqtt"

    def __str__(self) -> str:
        return f"{self.scheme}:{self.user}@{self.host}:{self.port}/{self.path}"


def read_address(text: str, scheme: str = "mqtt", *, is_insecure: bool = False) -> MqttAddress:
    """Read ``USER@HOST[:PORT]/TOPIC``.

    Raises:
        Malformed: It is something else.
        Refused: The broker is not on this host: what is said to it would be read on the way.
    """
    place, _, path = text.partition("/")
    user, mark, where = place.rpartition("@")
    host, _, port = where.partition(":")
    is_port = not port or (port.isdecimal() and int(port) < 65536)
    is_path = bool(path) and not any(c in "#+\0 " for c in path) and "//" not in f"/{path}/"
    if not (user and mark and host and is_port and is_path):
        raise Malformed(f"not {scheme}:USER@HOST[:PORT]/TOPIC: {scheme}:{text}")
    from rtkit.keys import reach

    reach.check(scheme, host, is_insecure=is_insecure)
    return MqttAddress(user, host, int(port or _PORTS[scheme]), path, scheme)
