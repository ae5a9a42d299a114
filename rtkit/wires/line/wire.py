"""Records of the line protocol: over a Unix socket of the user, and over TCP."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.errors import Malformed, Refused
from rtkit.wires.wire import (
    SERVICES,
    ClientSide,
    ProviderAddress,
    Wire,
    WireSettings,
    host_and_port,
    opened,
    place_to_open,
    shown_host,
    split_behind,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from rtkit.serving.provider import PropertyProvider
    from rtkit.wires.line.client import LineClient
    from rtkit.wires.property_client import PropertyClient


def _unix_provider(path: str, settings: WireSettings) -> ProviderAddress:
    from rtkit.property.naming import escape
    from rtkit.wires.line.client import connect_unix
    from rtkit.wires.line.provider_connection import LineConnection

    return ProviderAddress(
        lambda: LineConnection(settings.host, connect_unix(path, settings.timeout_s).detach()),
        escape(path.rpartition("/")[2].partition(".")[0]) or "service",
    )


def _open_unix(path: str, provider: PropertyProvider, settings: WireSettings) -> str:
    from rtkit.wires.line.endpoint import open_unix_at

    if not path:
        raise Malformed("not an endpoint: unix: (unix:PATH)")
    return f"unix:{open_unix_at(settings.host, provider.name, path)}"


UNIX = Wire(
    "unix",
    "Lines of text over a Unix socket of the user.",
    "unix:PATH",
    "unix:PATH",
    _unix_provider,
    _open_unix,
)


def _tcp_provider(address: str, settings: WireSettings) -> ProviderAddress:
    from rtkit.wires.line.client import connect_tcp

    return _provider("tcp", address, settings, connect_tcp)


def _tcps_provider(address: str, settings: WireSettings) -> ProviderAddress:
    from rtkit.wires.line.secure import connect_tcps

    return _provider("tcps", address, settings, connect_tcps)


def _provider(
    scheme: str,
    address: str,
    settings: WireSettings,
    connect: Callable[[str, int, float], LineClient],
) -> ProviderAddress:
    from rtkit.wires.line.provider_connection import LineConnection

    place, _, service = address.partition("/")
    host, port = host_and_port(place)

    if not service:
        with connect(host, port, settings.timeout_s) as client:
            known = str(client.ask(SERVICES).value()).strip("()").split()
        if len(known) != 1:
            present = " ".join(known) or "none"
            raise Refused(f"which service? {scheme}:{place}/NAME (there is {present})")
        service = known[0]
    return ProviderAddress(
        lambda: LineConnection(
            settings.host, connect(host, port, settings.timeout_s).detach(), service
        ),
        service,
    )


def _open_tcp(address: str, provider: PropertyProvider, settings: WireSettings) -> str:
    from rtkit.wires.line.endpoint import open_tcp

    place, port = place_to_open("tcp", address, settings)
    port = open_tcp(settings.host, provider.name, port, place)
    return opened(f"tcp:{shown_host(place)}:{port}", "tcp", place, settings)


def _endpoint(address: str) -> tuple[str, int]:
    return host_and_port(address.removeprefix("tcp:"))


def _connect(address: str, timeout_s: float) -> PropertyClient:
    from rtkit.wires.line.client import connect_tcp

    return connect_tcp(*_endpoint(address), timeout_s)


def _open_tcps(address: str, provider: PropertyProvider, settings: WireSettings) -> str:
    from rtkit.wires.line.secure import open_tcps

    place, port = place_to_open("tcps", address, settings)
    port = open_tcps(settings.host, provider.name, place, port)
    return f"tcps:{shown_host(place)}:{port}"


def _secure_endpoint(address: str) -> tuple[str, int]:
    return host_and_port(address.removeprefix("tcps:"))


def _connect_tcps(address: str, timeout_s: float) -> PropertyClient:
    from rtkit.wires.line.secure import connect_tcps

    return connect_tcps(*_secure_endpoint(address), timeout_s)


TCPS = Wire(
    "tcps",
    "Lines of text over TCP behind mutual TLS, for certificates of the same CA.",
    "tcps:HOST:PORT/SERVICE",
    "tcps:PORT",
    _tcps_provider,
    _open_tcps,
    ClientSide("tcps:", split_behind("tcps:"), _connect_tcps, check=_secure_endpoint),
)

TCP_CLIENTS = ClientSide("tcp:", split_behind("tcp:"), _connect, check=_endpoint)

TCP = Wire(
    "tcp",
    "Lines of text over TCP, for clients that know the user's secret.",
    "tcp:HOST:PORT/SERVICE",
    "tcp:PORT",
    _tcp_provider,
    _open_tcp,
    TCP_CLIENTS,
)
