"""Endpoints of the line protocol: a unix socket of the user, and TCP with the user's secret."""

from __future__ import annotations

import contextlib
import os
import socket
import stat
import time

from rtkit.errors import Refused
from rtkit.link import places, secret, unix
from rtkit.serving.acceptor import LOOPBACK, Acceptor, bound_to
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.line.login import Login
from rtkit.wires.line.server_connection import Connection, peer


class LineEndpoint(Acceptor):
    """Socket that accepts clients of the line protocol.

    Args:
        service: The one that clients mean where they name none.
        endpoint: What it is called in rules: the scheme of its wire.
        is_open_to_all: Of the host: clients have to show that they know the secret.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        end: socket.socket,
        service: str,
        endpoint: str,
        *,
        is_open_to_all: bool,
    ) -> None:
        self._service = service
        self._is_open_to_all = is_open_to_all
        super().__init__(host, end, endpoint)

    def admit(self, client: socket.socket) -> Connection | str:
        """See `Acceptor.enter`."""
        identity, login = "", None
        if self._is_open_to_all:
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            login = Login(secret.read(), time.monotonic(), self._host.services)
        else:
            identity = peer(client)
            if not identity:
                return "denied this is the endpoint of another user"
        return Connection(self._host, client, self._service, identity, login, self._quota)

    def reject(self, why: str) -> bytes:
        """See `Acceptor.reject`."""
        return f"! {why}\n".encode()


def open_unix(host: PropertyEventLoop, service: str) -> str:
    """Open the unix socket of a service, where commands find it by its name; return its path.

    Raises:
        Refused: A service of that name runs, or the path does not do.
    """
    places.make_private(places.runtime_path())
    path = places.service_socket(service)
    if unix.is_answering(path):
        raise Refused(f"a service named {service!r} is running already")
    return open_unix_at(host, service, path)


def open_unix_at(host: PropertyEventLoop, service: str, path: str) -> str:
    """Open a unix socket, for the same user; return its path.

    Raises:
        Refused: A process listens there, something else is there, or the path does not do.
    """
    places.check_socket_length(path)
    if unix.is_answering(path):
        raise Refused(f"somebody listens there already: {path}")
    with contextlib.suppress(FileNotFoundError):
        if not stat.S_ISSOCK(os.lstat(path).st_mode):
            raise Refused(f"exists and is no socket: {path}")
        os.unlink(path)
    end = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_CLOEXEC)
    try:
        end.bind(path)
    except OSError as error:
        end.close()
        raise Refused(f"cannot make the socket {path}: {error.strerror}") from error
    LineEndpoint(host, end, service, "unix", is_open_to_all=False)
    inode = os.stat(path).st_ino
    host.at_end(lambda: _remove(path, inode))
    return path


def open_tcp(host: PropertyEventLoop, service: str, port: int, address: str = LOOPBACK) -> int:
    """Open a port, 0 for any, to those who know the user's secret; return it.

    Raises:
        Unreachable: The port is taken.
        Refused: The secret cannot be made.
    """
    secret.make()
    end = bound_to(port, address)
    LineEndpoint(host, end, service, "tcp", is_open_to_all=True)
    return int(end.getsockname()[1])


def _remove(path: str, inode: int) -> None:
    with contextlib.suppress(FileNotFoundError):
        if os.stat(path).st_ino == inode:
            os.unlink(path)
