"""Line protocol behind mutual TLS: endpoint and client."""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.keys.tls import Trust
from rtkit.link.secret import Secret
from rtkit.property.messages import Answer, Payload
from rtkit.property.requests import Requester
from rtkit.serving.acceptor import bound_to
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.quota import EndpointQuota
from rtkit.wires.line.client import LineClient
from rtkit.wires.line.login import Login
from rtkit.wires.line.server_connection import Connection
from rtkit.wires.secure import SecureAcceptor, SecureClient, SecureStream, connected

_IDENTITY = "door/identity"


class Entered(Login):
    """Answers what is asked of the endpoint itself: its client is known by its certificate."""

    def __init__(self, services: Iterable[str]) -> None:
        super().__init__(Secret("", ""), 0.0, services)

    def take(self, caller: Requester, service: str, name: str, payload: Payload | None) -> Answer:
        """See `Login.take`; nobody becomes another."""
        if name == "identity" and payload is None:
            return Answer(caller.identity)
        if name == "services" and payload is None:
            return Answer(f"({' '.join(self._services)})")
        return Answer(f"no such property: door/{name}", "unknown")


class SecureConnection(SecureClient, Connection):
    """Client of the line protocol behind TLS."""

    def refusal_to_send(self, why: str) -> bytes:
        """See `SecureClient.refusal_to_send`."""
        return f"! denied {why}\n".encode()

    def _reply_at_once(self, data: bytes) -> bytes | None:
        # What is on record goes the long way.
        return None if data[:4] == b"SET " else super()._reply_at_once(data)


def open_tcps(host: PropertyEventLoop, service: str, address: str, port: int) -> int:
    """Open a port, 0 for any, to those who show a certificate; return it.

    Raises:
        Unreachable: The port is taken.
        NotFound: There are no keys.
        Refused: The keys cannot be used.
    """
    trust = Trust(is_server=True)
    end = bound_to(port, address)

    def client(stream: SecureStream, quota: EndpointQuota) -> SecureConnection:
        return SecureConnection(host, stream, service, "", Entered(host.services), quota)

    SecureAcceptor(host, end, trust, "tcps", client)
    return int(end.getsockname()[1])


def connect_tcps(host: str, port: int, timeout_s: float) -> LineClient:
    """Connect to an endpoint with the certificate of this user.

    Raises:
        Unreachable: Nobody listens there.
        PropertyError: ``denied``.
        NotFound: There are no keys.
    """
    client = LineClient(connected(host, port, timeout_s), timeout_s)  # type: ignore[arg-type]
    try:
        client.ask(_IDENTITY).value()  # a certificate that is refused is told only now
    except Exception:
        client.close()
        raise
    return client
