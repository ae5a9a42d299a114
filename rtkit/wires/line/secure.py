"""Line protocol behind mutual TLS: endpoint and client."""

from __future__ import annotations

import socket
from collections.abc import Iterable

from rtkit.errors import RtkitError
from rtkit.keys.tls import Trust
from rtkit.link.secret import Secret
from rtkit.property.messages import Answer, Payload
from rtkit.property.requests import Requester
from rtkit.serving.acceptor import Acceptor, bound_to
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.line.client import LineClient
from rtkit.wires.line.login import Login
from rtkit.wires.line.server_connection import Connection
from rtkit.wires.secure import SecureClient, connected, secured

_IDENTITY = "door/identity"


class _Entered(Login):
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


class SecureLineEndpoint(Acceptor):
    """Port for clients that show a certificate of the CA.

    Args:
        service: The one that clients mean where they name none.
    """

    def __init__(
        self, host: PropertyEventLoop, end: socket.socket, service: str, trust: Trust
    ) -> None:
        self._service = service
        self._trust = trust
        super().__init__(host, end, "tcps")

    def admit(self, client: socket.socket) -> Connection | str:
        """See `Acceptor.enter`."""
        try:
            address = str(client.getpeername()[0])
            stream = secured(client, self._trust)
        except (OSError, RtkitError) as error:
            return f"denied {error}"
        login = _Entered(self._host.services)
        made = SecureConnection(self._host, stream, self._service, "", login, self._quota)
        made.trust, made.address, made.wire = self._trust, address, "tcps"
        return made

    def reject(self, why: str) -> bytes:
        """See `Acceptor.reject`: before TLS there are no words."""
        return b""


def open_tcps(host: PropertyEventLoop, service: str, address: str, port: int) -> int:
    """Open a port, 0 for any, to those who show a certificate; return it.

    Raises:
        Unreachable: The port is taken.
        NotFound: There are no keys.
        Refused: The keys cannot be used.
    """
    trust = Trust(is_server=True)
    end = bound_to(port, address)
    SecureLineEndpoint(host, end, service, trust)
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
