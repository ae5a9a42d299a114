"""Table of the wires: the one place that lists them."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rtkit.wires.wire import ClientSide, Wire

PORT = "[HOST:]PORT"


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
    "zenoh": WireEntry("zenoh"),
    "serial": WireEntry(
        "serial",
        ServeOption(
            "serial",
            "DEVICE",
            "Also open this serial line (DEVICE?baud=115200&check=auto).",
            knows_clients=False,
        ),
    ),
    "http": WireEntry(
        "http",
        ServeOption("http", PORT, "Also open an HTTP endpoint on this host, 0 for any free port."),
    ),
    "mqtt": WireEntry("mqtt"),
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


def endpoint_side_of(address: str) -> ClientSide:
    """Return how clients reach an endpoint: without a scheme it is ``HOST:PORT`` of TCP."""
    from rtkit.wires.line.wire import TCP_CLIENTS

    return client_side_of(address) or TCP_CLIENTS


def client_side_of(address: str) -> ClientSide | None:
    """Return how commands reach what an address names, None if it is no address of a wire."""
    scheme, mark, _ = address.partition(":")
    if not mark or scheme not in WIRES:
        return None
    client = wire_of(scheme).client
    return client if client is not None and address.startswith(client.prefix) else None
