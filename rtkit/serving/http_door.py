"""The HTTP door: a port of this host, for who knows the user's secret."""

from __future__ import annotations

import contextlib
import socket

from rtkit.errors import Refused, Unreachable
from rtkit.link import secret
from rtkit.serving.doors import LOOPBACK
from rtkit.serving.host import Host
from rtkit.serving.room import Room

_BACKLOG = 128


class HttpDoor:
    """A socket that takes clients, bounded in number."""

    def __init__(self, host: Host, end: socket.socket) -> None:
        from rtkit.serving.http_connection import HttpConnection
        from rtkit.serving.http_guard import Guard

        self._connection = HttpConnection
        self._host = host
        self._end = end
        self._guard = Guard(secret.read())
        self._clients: list[HttpConnection] = []
        self._room = Room(host.policy, "http", lambda: self._clients)
        end.setblocking(False)
        end.listen(_BACKLOG)
        host.register(end, self)

    def ready(self, mask: int) -> None:
        """See `Tenant.ready`."""
        try:
            client, _ = self._end.accept()
        except OSError:
            return  # it has gone again, or there is no descriptor left: the next one may fit
        self._clients = [each for each in self._clients if each.is_open]
        if len(self._clients) >= self._room.limits.connections:
            _turn_away(client, self._room.limits.connections)
            return
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._clients.append(self._connection(self._host, client, self._guard, self._room))

    def flush(self, now: float) -> float | None:
        """See `Tenant.flush`."""
        return None

    def check(self, now: float) -> None:
        """See `Tenant.check`."""


def _turn_away(client: socket.socket, most: int) -> None:
    text = f"busy there are {most} connections\n"
    head = "HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nRetry-After: 1\r\n"
    with contextlib.suppress(OSError):
        client.setblocking(False)
        client.send(f"{head}Content-Length: {len(text)}\r\n\r\n{text}".encode())
    client.close()


def open_http(host: Host, port: int) -> int:
    """Open a port of this host, 0 for any, to those who know the user's secret; return it.

    Raises:
        Refused: The package h11 is not there, or the secret cannot be made.
        Unreachable: The port is taken.
    """
    try:
        import h11  # noqa: F401
    except ImportError:
        raise Refused("HTTP needs the package h11: pip install 'rtkit[http]'") from None
    secret.make()
    end = socket.socket(socket.AF_INET, socket.SOCK_STREAM | socket.SOCK_CLOEXEC)
    end.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        end.bind((LOOPBACK, port))
    except OSError as error:
        end.close()
        raise Unreachable(f"cannot listen on port {port}: {error.strerror}") from error
    HttpDoor(host, end)
    return int(end.getsockname()[1])
