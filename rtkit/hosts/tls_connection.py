"""Connection to the router of a manager on another host, over mutual TLS, at its port for that.

Its other end is `rtkit.manager.gateway.router_end`; whoever is let through to a router may do all
there, so that takes an administrator.
"""

from __future__ import annotations

import json
import select
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import cast

from rtkit.closing import Closing
from rtkit.errors import NotFound, Refused, RtkitError, Unreachable
from rtkit.hosts.host import Host
from rtkit.hosts.silence import await_silence, longest_silence
from rtkit.keys.tls import Trust, peer_of
from rtkit.link import zenoh_keys
from rtkit.property.codes import PropertyError
from rtkit.wires.line.client import LineClient
from rtkit.wires.secure import SecureStream, connected

_IDENTITY, _ROUTER = "~identity", "%40x%2Frouter"
_TIMEOUT_S = 10.0


class TlsConnection(Closing):
    """Bytes to and from a router on another host, and a second connection that asks for life.

    Attributes:
        longest_silence_s: How long the far side may be silent until it is given up [s].
        id: By which the gateway there knows it; empty where that is of an older version.
    """

    def __init__(self, host: Host, near: str, former: str = "") -> None:
        """Connect.

        Args:
            host: Where to.
            near: Name of this host there.
            former: Id of the connection of the link before, which ends first; empty for none.

        Raises:
            Unreachable: Nobody answers there, or another manager than was meant.
            Refused: It is not trusted, or lets this user do no such thing.
        """
        self._host = host
        self._lock = threading.Lock()
        self._asking = _client(host)
        try:
            began = time.monotonic()
            _check(host, self._asking)
            self.longest_silence_s = longest_silence(time.monotonic() - began)
            client = _client(host)
            try:
                self.id = _asked(host, client, _ROUTER, f"{near} {former}".rstrip())
            except BaseException:
                client.close()
                raise
        except BaseException:
            self._asking.close()
            raise
        self._end = cast(SecureStream, client.detach())
        self._end.setblocking(False)
        self._trust, self._peer = Trust(is_server=False), peer_of(self._end.tls)

    def recv(self, size: int) -> bytes:
        """Return what has come, nothing at the end of the connection."""
        while True:
            with self._lock, suppress(BlockingIOError):  # OpenSSL bears one thread at a time
                return self._end.recv(size)
            select.select([self._end], [], [])

    def sendall(self, data: bytes) -> None:
        """Send all of it."""
        view = memoryview(data)
        while view:
            with self._lock:
                try:
                    view = view[self._end.send(view) :]
                    continue
                except BlockingIOError:
                    pass
            select.select([], [self._end], [])

    def await_silence(self, silence_s: Callable[[], float]) -> str:
        """See `rtkit.hosts.silence.await_silence`."""

        def ask() -> None:
            if why := self._trust.refusal(self._peer):
                raise Refused(why)
            self._asking.ask(_IDENTITY).value()

        return await_silence(ask, self.longest_silence_s, silence_s)

    def close(self) -> None:
        """End it."""
        self._asking.close()
        with suppress(OSError):  # whoever waits for it hears that; the socket knows of no TLS
            socket.socket.shutdown(self._end.tls, socket.SHUT_RDWR)


def _client(host: Host) -> LineClient:
    with _explained(host):
        end = connected(host.address, host.port, _TIMEOUT_S)
    return LineClient(end, _TIMEOUT_S)  # type: ignore[arg-type]


def _asked(host: Host, client: LineClient, target: str, payload: str | None = None) -> str:
    with _explained(host):
        return str(client.ask(target, payload).value())


@contextmanager
def _explained(host: Host) -> Iterator[None]:
    """Say what a failure means to a user."""
    try:
        yield
    except PropertyError as error:
        raise Refused(f"{host.name}: {error.code}: {error}") from error
    except NotFound as error:
        raise Refused(f"{host.name}: {error}") from error
    except RtkitError as error:
        raise type(error)(f"{host.name}: {error}") from error


def _check(host: Host, client: LineClient) -> None:
    """Look whether it is the manager that is meant.

    Raises:
        Refused: It is another one.
    """
    try:
        realm, far, manager, _ = map(str, json.loads(_asked(host, client, _IDENTITY)))
    except ValueError as error:
        raise Unreachable(f"{host.name}: no manager at {host}: {error}") from error
    if realm != zenoh_keys.realm():
        raise Refused(f"{host.name}: the manager at {host} is of another realm: {realm}")
    host.check_manager(far, manager)
