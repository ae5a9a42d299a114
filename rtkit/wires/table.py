"""Table of the wires: the one place that lists them."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rtkit.wires.wire import ClientSide, Wire

WIRES = {
    "unix": "line",
    "tcp": "line",
    "zenoh": "zenoh",
    "serial": "serial",
    "http": "http",
    "mqtt": "mqtt",
    "ice": "ice",
}
"""Package of `rtkit.wires` by scheme; its module ``wire`` holds the record ``SCHEME``."""


def wire_of(scheme: str) -> Wire:
    """Return the record of a scheme of the table."""
    # Only the record that is asked for is loaded: commands do this at each start.
    module = import_module(f"rtkit.wires.{WIRES[scheme]}.wire")
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
