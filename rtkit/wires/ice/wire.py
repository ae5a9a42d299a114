"""Record of Ice: each service is an object."""

from __future__ import annotations

from rtkit.errors import Malformed
from rtkit.wires.wire import ClientSide, ProviderAddress, Wire, WireSettings, loaded, split_behind

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


ICE = Wire(
    "ice",
    "ZeroC Ice: each service is an object.",
    "ice://HOST:PORT/SERVICE",
    "ice:PORT",
    _provider,
    loaded("ice.endpoint:open_ice"),
    ClientSide(_PREFIX, split_behind(_PREFIX), loaded("ice.client:connect_ice")),
    extra="ice",
)
