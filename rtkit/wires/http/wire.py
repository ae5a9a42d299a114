"""Records of HTTP: with the secret of the user, and behind mutual TLS."""

from __future__ import annotations

from functools import partial
from typing import Any

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
_connect_https = loaded("http.secure:connect_https")


def _provider(
    address: str, settings: WireSettings, scheme: str = "http", connect: Any = _connect
) -> ProviderAddress:
    from rtkit.wires.blocking_connection import blocking_calls

    place, _, service = address.removeprefix("//").partition("/")
    service = service.removeprefix("ps/").rstrip("/")
    if not service:
        raise Malformed(f"not {scheme}://HOST:PORT/ps/SERVICE: {scheme}:{address}")
    return ProviderAddress(
        blocking_calls(
            settings.host, lambda: connect(f"{scheme}://{place}", settings.timeout_s, service)
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

HTTPS = Wire(
    "https",
    "HTTP/1.1 behind mutual TLS, for certificates of the same CA.",
    "https://HOST:PORT/ps/SERVICE",
    "https:PORT",
    partial(_provider, scheme="https", connect=_connect_https),
    loaded("http.secure:open_https"),
    ClientSide("https://", split_behind("https://", "/ps/"), _connect_https, folder="/ps"),
    extra="http",
)
