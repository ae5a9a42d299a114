"""Record of Ice: each service is an object."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.errors import Malformed
from rtkit.wires.wire import (
    ClientSide,
    ProviderAddress,
    Wire,
    WireSettings,
    port_here,
    split_behind,
)

if TYPE_CHECKING:
    from rtkit.serving.provider import PropertyProvider
    from rtkit.wires.property_client import PropertyClient

_PREFIX = "ice://"


def _provider(address: str, settings: WireSettings) -> ProviderAddress:
    from rtkit.wires.ice.address import read_address
    from rtkit.wires.ice.provider_connection import IceConnection

    place = read_address(f"ice:{address}")
    if not place.service:
        raise Malformed(f"not ice://HOST:PORT/SERVICE: ice:{address}")
    return ProviderAddress(
        lambda: IceConnection(settings.host, place, settings.timeout_s), place.service
    )


def _open(address: str, provider: PropertyProvider, settings: WireSettings) -> str:
    from rtkit.wires.ice.endpoint import open_ice

    port = open_ice(settings.host, port_here("ice", address))
    return f"{_PREFIX}localhost:{port}/{provider.name}"


def _connect(address: str, timeout_s: float) -> PropertyClient:
    from rtkit.wires.ice.client import connect_ice

    return connect_ice(address, timeout_s)


ICE = Wire(
    "ice",
    "ZeroC Ice: each service is an object.",
    "ice://HOST:PORT/SERVICE",
    "ice:PORT",
    _provider,
    _open,
    ClientSide(_PREFIX, split_behind(_PREFIX), _connect),
    extra="ice",
)
