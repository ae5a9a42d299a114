"""HTTP endpoint: a port of this host, for clients that know the user's secret."""

from __future__ import annotations

import socket

from rtkit.errors import Refused
from rtkit.extras import how_to_get
from rtkit.keys import reach
from rtkit.link import secret
from rtkit.link.places import host_name
from rtkit.property.access import EndpointLimits
from rtkit.serving.acceptor import Acceptor, bound_to
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.serving.socket_client import SocketClient
from rtkit.wires.wire import WireSettings, opened, place_to_open, shown_host

# A browser opens several connections a page, and polls: fewer and slower than other clients.
LIMITS = EndpointLimits(connections=128, door_listeners=4096, rate=2000)


class HttpEndpoint(Acceptor):
    """Socket that accepts clients of HTTP."""

    def __init__(self, host: PropertyEventLoop, end: socket.socket) -> None:
        from rtkit.wires.http.guard import Guard
        from rtkit.wires.http.server_connection import HttpConnection

        self._connection = HttpConnection
        self._guard = Guard(secret.read())
        self._is_public = not reach.is_here(str(end.getsockname()[0]))
        super().__init__(host, end, "http", LIMITS)

    def admit(self, client: socket.socket) -> SocketClient:
        """See `Acceptor.enter`."""
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        from rtkit.wires.http.guard import HERE

        names = HERE
        if self._is_public:
            names |= {host_name().lower(), str(client.getsockname()[0])}
        return self._connection(self._host, client, self._guard, self._quota, names)

    def reject(self, why: str) -> bytes:
        """See `Acceptor.reject`."""
        text = f"{why}\n"
        head = "HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nRetry-After: 1\r\n"
        return f"{head}Content-Length: {len(text)}\r\n\r\n{text}".encode()


def check_h11() -> None:
    """Check that HTTP can be spoken.

    Raises:
        Refused: The package h11 is not there.
    """
    try:
        import h11  # noqa: F401
    except ImportError:
        raise Refused(f"HTTP needs the package h11: {how_to_get('http')}") from None


def open_http(address: str, provider: PropertyProvider, settings: WireSettings) -> str:
    """Open a port of this host, 0 for any, to those who know the user's secret.

    Raises:
        Refused: The package h11 is not there, or the secret cannot be made.
        Unreachable: The port is taken.
    """
    place, port = place_to_open("http", address, settings)
    check_h11()
    secret.make()
    end = bound_to(port, place)
    HttpEndpoint(settings.host, end)
    where = f"http://{shown_host(place)}:{end.getsockname()[1]}/ps/{provider.name}"
    return opened(where, "http", place, settings)
