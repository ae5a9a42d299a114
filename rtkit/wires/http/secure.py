"""HTTP behind mutual TLS: endpoint and client; who asks is known by the certificate."""

from __future__ import annotations

import ssl
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

from rtkit.errors import Malformed
from rtkit.keys.tls import Trust
from rtkit.serving.acceptor import bound_to
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.serving.quota import EndpointQuota
from rtkit.wires.http.client import BoundedReads, HttpClient, parse_address
from rtkit.wires.http.endpoint import LIMITS, check_h11
from rtkit.wires.secure import SecureAcceptor, SecureClient, SecureStream, connected
from rtkit.wires.wire import WireSettings, place_to_open, shown_host

if TYPE_CHECKING:
    from collections.abc import Callable


class _BoundedTls(BoundedReads, ssl.SSLSocket):
    """Socket behind TLS whose reads end at one moment, or that says as others that nothing came."""

    def sendall(self, *args: Any) -> None:
        """Send all of it; who has been denied meanwhile is told so, not that nobody listens."""
        try:
            super().sendall(*args)
        except OSError:
            self.recv(1)  # raises what the other side said last, if that was anything
            raise

    def recv(self, *args: int) -> bytes:
        """Receive what is there, or comes in time."""
        try:
            return super().recv(*args)
        except ssl.SSLWantReadError:
            raise BlockingIOError from None


def open_https(address: str, provider: PropertyProvider, settings: WireSettings) -> str:
    """Open a port, 0 for any, to those who show a certificate.

    Raises:
        Refused: The package h11 is not there, or the keys cannot be used.
        NotFound: There are no keys.
        Unreachable: The port is taken.
    """
    check_h11()
    place, port = place_to_open("https", address, settings)
    trust = Trust(is_server=True)
    end = bound_to(port, place)
    SecureAcceptor(settings.host, end, trust, "https", _connection(settings.host), LIMITS)
    return f"https://{shown_host(place)}:{end.getsockname()[1]}/ps/{provider.name}"


def _connection(host: PropertyEventLoop) -> Callable[[SecureStream, EndpointQuota], SecureClient]:
    from rtkit.wires.http.guard import Verdict
    from rtkit.wires.http.server_connection import HttpConnection

    class SecureHttpConnection(SecureClient, HttpConnection):  # type: ignore[misc]
        """Client of HTTP behind TLS."""

        _scheme = "https"

        def refusal_to_send(self, why: str) -> bytes:
            """See `SecureClient.refusal_to_send`."""
            text = f"denied {why}\n".encode()
            status = f"{HTTPStatus.FORBIDDEN.value} {HTTPStatus.FORBIDDEN.phrase}"
            head = f"HTTP/1.1 {status}\r\nConnection: close\r\nContent-Length: {len(text)}\r\n\r\n"
            return head.encode() + text

        def _verdict(self, method: str, uri: str) -> Verdict:
            return Verdict(self.identity)

    return lambda stream, quota: SecureHttpConnection(host, stream, None, quota)


def connect_https(address: str, timeout_s: float, service: str = "") -> HttpClient:
    """Return a client of an endpoint, with the certificate of this user.

    Raises:
        Malformed: It is no address.
    """
    where = parse_address(address, "https")
    if where is None:
        raise Malformed(f"not https://HOST:PORT[/ps/SERVICE]: {address}")
    client = HttpClient(*where, None, timeout_s, service)
    client.use(lambda host, port, left_s: connected(host, port, left_s, _BoundedTls).tls)  # type: ignore[arg-type,return-value]
    return client
