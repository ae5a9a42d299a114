"""Record of HTTP."""

from __future__ import annotations

from rtkit.errors import Malformed
from rtkit.wires.wire import (
    ClientSide,
    ProviderAddress,
    Wire,
    WireSettings,
    loaded,
    split_behind,
)

_connect = loaded("http.client:connect_http")


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


HTTP = Wire(
    "http",
    "HTTP/1.1, with digest authentication by the user's secret.",
    "http://HOST:PORT/ps/SERVICE",
    "http:PORT",
    _provider,
    loaded("http.endpoint:open_http"),
    ClientSide("http://", split_behind("http://", "/ps/"), _connect, folder="/ps"),
    extra="http",
)
