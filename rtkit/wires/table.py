"""Table of the wires: the one place that lists them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.wires.wire import ClientSide, Wire

PORT = "[HOST:]PORT"
PUBLIC = "[ADDRESS:]PORT"
"""Place of an endpoint with mutual TLS: the only ones that other hosts can reach."""
_WITHOUT_SCHEME = "tcp"


class ServeOption(NamedTuple):
    """Option of ``rtserve``, and keyword of `rtkit.serve`, that opens an endpoint.

    Attributes:
        metavar: Form of its value; `PORT` is checked when the command line is read.
        knows_clients: Whether the endpoint learns who its clients are.
    """

    name: str
    metavar: str
    help: str
    knows_clients: bool = True


class WireEntry(NamedTuple):
    """Entry of the table: what is known of a wire before its record is loaded.

    Attributes:
        package: Of `rtkit.wires`; its module ``wire`` holds the record ``SCHEME``.
        option: How an object is served over it, None if only proxies open it.
    """

    package: str
    option: ServeOption | None = None


WIRES = {
    "unix": WireEntry("line"),
    "tcp": WireEntry(
        "line",
        ServeOption("port", PORT, "Also open a TCP endpoint on this host, 0 for any free port."),
    ),
    "tcps": WireEntry(
        "line",
        ServeOption(
            "tls", PUBLIC, "Also open a TCP endpoint with mutual TLS (0.0.0.0:PORT: other hosts)."
        ),
    ),
    "zenoh": WireEntry("zenoh"),
    "serial": WireEntry(
        "serial",
        ServeOption(
            "serial",
            "DEVICE",
            "Also open this serial line (DEVICE?baud=115200&check=auto&address=7).",
            knows_clients=False,
        ),
    ),
    "http": WireEntry(
        "http",
        ServeOption("http", PORT, "Also open an HTTP endpoint on this host, 0 for any free port."),
    ),
    "https": WireEntry(
        "http",
        ServeOption(
            "https", PUBLIC, "Also open an HTTP endpoint with mutual TLS, for other hosts, too."
        ),
    ),
    "mqtt": WireEntry("mqtt"),
    "mqtts": WireEntry("mqtt"),
    "ice": WireEntry(
        "ice",
        ServeOption("ice", PORT, "Also open an Ice endpoint on this host, 0 for any free port."),
    ),
}
"""What there is, by scheme."""


def wire_of(scheme: str) -> Wire:
    """Return the record of a scheme of the table."""
    # Only the record that is asked for is loaded: commands do this at each start.
    module = import_module(f"rtkit.wires.{WIRES[scheme].package}.wire")
    wire: Wire = getattr(module, scheme.upper())
    return wire


def wires() -> Iterator[Wire]:
    """Yield the records of all wires."""
    return map(wire_of, WIRES)


def scheme_of(address: str) -> str:
    """Return the scheme of an address, empty for none: ``HOST:PORT``, as printed, is one of TCP."""
    scheme, mark, _ = address.partition(":")
    if mark and scheme in WIRES:
        return scheme
    return _WITHOUT_SCHEME if re.fullmatch(r"[\w.\-]+:\d+(/.*)?", address) else ""


def endpoint_of(typed: str) -> tuple[ClientSide, str, str]:
    """Return how clients reach an endpoint, its address, and the service that is named behind it.

    Raises:
        Malformed: It is no address of an endpoint that has clients.
    """
    side = client_side_of(typed) or wire_of(_WITHOUT_SCHEME).client
    assert side is not None
    place, service = side.split(typed) if side.has_services else (typed, "")
    side.check(place)
    return side, place, service.strip("/")


def client_side_of(address: str) -> ClientSide | None:
    """Return how commands reach what an address names, None if it is no address of a wire.

    Raises:
        Malformed: It is one of a wire that has no clients, or in another form.
    """
    scheme = scheme_of(address)
    if not scheme:
        return None
    wire = wire_of(scheme)
    if wire.client is None:
        hint = f"rtproxy {wire.source} NAME, then NAME.PROPERTY"
        raise Malformed(f"{scheme}: is a wire for rtproxy, not for rtget, rtset, rtlisten ({hint})")
    if address.startswith(f"{scheme}:") and not address.startswith(wire.client.prefix):
        raise Malformed(f"not {wire.source}: {address}")
    return wire.client
