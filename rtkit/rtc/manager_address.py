"""Direct addresses of managers: ``corbaloc:[iiop]:host[:port][/id]``, or ``host:port``."""

from __future__ import annotations

from typing import NamedTuple

from rtkit.errors import Malformed

DEFAULT_PORT = 2810
DEFAULT_ID = "manager"
_SCHEME = "corbaloc:"


class Address(NamedTuple):
    """Address of a manager; an empty `id` matches any manager that listens there."""

    host: str
    port: int
    id: str = ""

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


def is_address(text: str) -> bool:
    """Return whether a text means a manager by where it listens."""
    host, colon, port = text.partition(":")
    return text.startswith(_SCHEME) or bool(host and colon and port.isdigit())


def parse_address(text: str) -> Address:
    """Read a direct address.

    Raises:
        Malformed: It cannot be read.
    """
    if not text.startswith(_SCHEME):
        host, _, port = text.rpartition(":")
        if not host or not is_port(port):
            raise Malformed(f"not HOST:PORT: {text}")
        return Address(host, int(port))
    protocol, _, rest = text.removeprefix(_SCHEME).partition(":")
    place, slash, id = rest.partition("/")
    host, colon, port = place.partition(":")
    is_bad_id = bool(slash) and (not id or "/" in id)
    if protocol not in ("", "iiop") or not host or is_bad_id or (colon and not is_port(port)):
        raise Malformed("Invalid corbaloc URL.")
    return Address(host, int(port or DEFAULT_PORT), id or DEFAULT_ID)


def is_port(text: str) -> bool:
    """Return whether a text is the number of a port that can be connected to."""
    return text.isascii() and text.isdigit() and 0 < int(text) < 65536
