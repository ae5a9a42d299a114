"""Link to a manager of this host: requests over its own socket, all else over zenoh.

A command that asks a few things, as most do, loads and opens no zenoh. See decision 99.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from threading import Lock
from typing import TYPE_CHECKING

from rtkit.errors import Unreachable
from rtkit.link import places, zenoh_keys
from rtkit.link.requests import client
from rtkit.link.requests.client import GONE, ConnectionEnded, RequestConnection
from rtkit.link.transport import Link

if TYPE_CHECKING:
    from rtkit.link.zenoh import ZenohLink
    from rtkit.property.exchange import Reply

_ORDER_S = 10.0


class ManagerLink(Link):
    """Link that asks a manager directly, until something else is wanted of it.

    From then on zenoh carries everything: a change that was listened to before a request is to
    come before its reply.

    Args:
        manager: Its name.
        service: Its key.
        connection: To it.
        timeout_s: Bound on opening zenoh [s].
    """

    def __init__(
        self, manager: str, service: str, connection: RequestConnection, timeout_s: float
    ) -> None:
        self._manager = manager
        self._prefixes = (f"{service}/@/", f"{service}/@x/")
        self._skip = len(service) + 1
        self._connection = connection
        self._timeout_s = timeout_s
        self._lock = Lock()
        self._zenoh: ZenohLink | None = None
        self._is_closed = False

    def send(self, key: str, payload: str | None, timeout_s: float) -> Callable[[], Reply]:
        """See `Link.send`."""
        if self._zenoh is not None or not key.startswith(self._prefixes):
            return self._all().send(key, payload, timeout_s)
        name = key[self._skip :]
        with suppress(ConnectionEnded):  # since it was looked at; nothing has been taken
            return self._connected(timeout_s).send(name, payload, timeout_s)
        try:
            return self._connected(timeout_s).send(name, payload, timeout_s)
        except ConnectionEnded as error:
            raise Unreachable(GONE) from error

    def listen(self, key: str, on_text: Callable[[str], object]) -> Callable[[], object]:
        """See `Link.listen`."""
        return self._all().listen(key, on_text)

    def notice(self, key: str, found: Callable[[bool], object]) -> Callable[[], object]:
        """See `Link.notice`."""
        return self._all().notice(key, found)

    def close(self) -> None:
        """See `Link.close`."""
        with self._lock:
            self._is_closed = True
            self._connection.close()
            if self._zenoh is not None:
                self._zenoh.close()

    def _connected(self, timeout_s: float) -> RequestConnection:
        """Return the connection, a new one where the manager has been started again."""
        with self._lock:
            if self._is_closed:
                raise Unreachable("the connection is closed")
            if self._connection.has_ended:
                path = places.request_socket(self._manager)
                try:
                    connection = client.connect(path, timeout_s)
                except OSError as error:
                    raise Unreachable(GONE) from error
                self._connection.close()
                self._connection = connection
            return self._connection

    def _all(self) -> ZenohLink:
        """Return the link by which everything goes from now on."""
        with self._lock:
            if self._is_closed:
                raise Unreachable("the connection is closed")
            if self._zenoh is None:
                opened = open_zenoh(self._manager, self._timeout_s)
                self._await_order()
                self._zenoh = opened
            return self._zenoh

    def _await_order(self) -> None:
        """Wait until the manager has taken what was sent: the next request comes another way."""
        try:
            self._connection.send("@/manager.pid", None, _ORDER_S)()
        except (ConnectionEnded, Unreachable):
            return  # then it takes nothing that was sent


def open_link(manager: str, host: str, timeout_s: float) -> Link:
    """Connect to a manager of this host, of this version or an older one.

    Raises:
        Unreachable: It does not run, or does not answer in time [s].
        Refused: Another user can have laid its socket.
    """
    path = places.request_socket(manager)
    try:
        connection = client.connect(path, timeout_s)
    except TimeoutError as error:
        raise Unreachable(f"no answer within {timeout_s:g} s") from error
    except OSError:  # an older one has none, and one that ends has it no more
        return open_zenoh(manager, timeout_s)
    return ManagerLink(manager, zenoh_keys.service(host, manager), connection, timeout_s)


def open_zenoh(manager: str, timeout_s: float) -> ZenohLink:
    """Connect to a manager of this host over zenoh.

    Raises:
        Unreachable: It does not run, or does not answer in time [s].
        Refused: Another user can have laid its socket.
    """
    from rtkit.link.zenoh import ZenohLink, open_client, unix_endpoint

    return ZenohLink(open_client(unix_endpoint(places.manager_socket(manager)), timeout_s))
