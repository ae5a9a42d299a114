"""Accepts clients on sockets, as many as the quota allows; sends the others a reason."""

from __future__ import annotations

import contextlib
import socket
from abc import abstractmethod

from rtkit.errors import Unreachable
from rtkit.property.access import DEFAULT_LIMITS, EndpointLimits
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop
from rtkit.serving.quota import EndpointQuota
from rtkit.serving.socket_client import SocketClient

LOOPBACK = "127.0.0.1"
_BACKLOG = 128


class Acceptor(IOHandler):
    """Listening socket that clients connect to.

    Args:
        end: Bound; it is listened at from now on.
        endpoint: Name of the endpoint in rules.
        limits: Where no rule says anything else.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        end: socket.socket,
        endpoint: str,
        limits: EndpointLimits = DEFAULT_LIMITS,
    ) -> None:
        self._host = host
        self._end = end
        self._clients: list[SocketClient] = []
        self._quota = EndpointQuota(host.policy, endpoint, lambda: self._clients, limits=limits)
        end.setblocking(False)
        end.listen(_BACKLOG)
        host.register(end, self)

    @abstractmethod
    def admit(self, client: socket.socket) -> SocketClient | str:
        """Admit a client, or return the refusal to send it: code, blank, words."""

    @abstractmethod
    def reject(self, why: str) -> bytes:
        """Return the bytes that give a rejected client the reason."""

    def ready(self, mask: int) -> None:
        """See `IOHandler.ready`."""
        try:
            client, _ = self._end.accept()
        except OSError:
            return  # it has gone again, or there is no descriptor left: the next one may fit
        self._forget()
        most = self._quota.limits.connections
        is_full = len(self._clients) >= most and not self._make_room()
        admitted = f"busy there are {most} connections" if is_full else self.admit(client)
        if not isinstance(admitted, str):
            self._clients.append(admitted)
            return
        with contextlib.suppress(OSError):  # a client that does not wait for the word goes without
            client.setblocking(False)
            client.send(self.reject(admitted))
        client.close()

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`."""
        return None

    def check(self, now: float) -> None:
        """See `IOHandler.check`."""
        self._forget()

    def _make_room(self) -> bool:
        """Close the oldest client that has not shown who it is; return whether there was one."""
        unknown = next((each for each in self._clients if not each.identity), None)
        if unknown is not None:
            unknown.close()
            self._forget()
        return unknown is not None

    def _forget(self) -> None:
        self._clients = [each for each in self._clients if each.is_open]


def bound_to(port: int, address: str = LOOPBACK) -> socket.socket:
    """Return a socket at a port, 0 for any; `rtkit.keys.reach` says at which addresses.

    Raises:
        Unreachable: The port is taken.
    """
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    end = socket.socket(family, socket.SOCK_STREAM | socket.SOCK_CLOEXEC)
    end.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        end.bind((address, port))
    except OSError as error:
        end.close()
        why = error.strerror or str(error)
        raise Unreachable(f"cannot listen on port {port}: {why}") from error
    return end
