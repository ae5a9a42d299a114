"""Record of HTTP."""

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
    from rtkit.wires.property_client import BoundedClient

_ROOT = "/ps/"


def _provider(address: str, settings: WireSettings) -> ProviderAddress:
    from rtkit.wires.blocking_connection import blocking_calls

    place, _, service = address.removeprefix("//").partition("/")
    service = service.removeprefix("ps/").rstrip("/")
    if not service:
        raise Malformed(f"not http://HOST:PORT/ps/SERVICE: http:{address}")
    return ProviderAddress(
        blocking_calls(
            settings.host, lambda: _connect(f"http://{place}", settings.timeout_s, service)
        ),
        service,
    )


def _open(address: str, provider: PropertyProvider, settings: WireSettings) -> str:
    from rtkit.wires.http.endpoint import open_http

    port = open_http(settings.host, port_here("http", address))
    return f"http://localhost:{port}{_ROOT}{provider.name}"


def _connect(address: str, timeout_s: float, service: str = "") -> BoundedClient:
    from rtkit.wires.http.client import connect_http

    return connect_http(address, timeout_s, service)


HTTP = Wire(
    "http",
    "HTTP/1.1, with digest authentication by the user's secret.",
    "http://HOST:PORT/ps/SERVICE",
    "http:PORT",
    _provider,
    _open,
    ClientSide("http://", split_behind("http://", _ROOT), _connect),
    extra="http",
)
