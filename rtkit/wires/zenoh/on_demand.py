"""Opens the zenoh endpoint of a service when somebody could use it; until then none is loaded.

Who speaks zenoh comes through the manager of this host, or to the socket of the service. As long as
there is no such manager, that socket is a bare one: who connects to it, or a manager that starts,
has zenoh loaded. The library takes more memory than all else of a small service, and threads.

See decision 92.
"""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Iterable
from contextlib import suppress
from logging import getLogger

from rtkit.errors import RtkitError
from rtkit.link import places, unix
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop
from rtkit.serving.provider import PropertyProvider

_BACKLOG = 16


def open_when_needed(
    host: PropertyEventLoop, service: PropertyProvider, hosts: Iterable[str] = ()
) -> None:
    """Answer zenoh queries for a service: at once where a manager runs or other hosts may ask.

    On the loop's thread, or before it runs.

    Raises:
        Refused: The path of the socket does not do.
        Unreachable: The socket cannot be made.
    """
    hosts = list(hosts)
    if hosts or _has_manager():
        from rtkit.wires.zenoh.endpoint import open_zenoh

        open_zenoh(host, service, hosts)
    else:
        ZenohOnDemand(host, service)


def _has_manager() -> bool:
    manager = places.usual_manager()
    has_socket = os.path.exists(places.manager_socket(manager))  # else there is no lock to look at
    return has_socket and places.owner(manager) is not None


class ZenohOnDemand(IOHandler):
    """Socket in the place of a zenoh endpoint, and look-out for a manager."""

    def __init__(self, host: PropertyEventLoop, service: PropertyProvider) -> None:
        self._host = host
        self._service = service
        self._path = places.check_socket_length(places.service_key_socket(service.name))
        self._end = unix.listen(self._path, backlog=_BACKLOG)
        self._end.setblocking(False)
        self._clients: list[socket.socket] = []
        self._opening: threading.Thread | None = None
        host.register(self._end, self)
        host.at_end(self.close)

    def ready(self, mask: int) -> None:
        """See `IOHandler.ready`."""
        self._admit()
        if self._clients:
            self._begin()

    def flush(self, now: float) -> None:
        """See `IOHandler.flush`."""

    def check(self, now: float) -> None:
        """See `IOHandler.check`."""
        if _has_manager():
            self._begin()

    def _begin(self) -> None:
        if self._opening is None:
            # Not on the loop: to load the library takes as long as hundreds of requests.
            self._opening = threading.Thread(target=self._open, name="zenoh", daemon=True)
            self._opening.start()

    def _admit(self) -> None:
        with suppress(BlockingIOError):
            while True:
                self._clients.append(self._end.accept()[0])

    def _open(self) -> None:
        """Put zenoh in the place of the socket; those who wait there then try anew."""
        from rtkit.wires.zenoh.endpoint import open_zenoh

        with self._host.lock:
            self._admit()
            self._stop()
        try:
            open_zenoh(self._host, self._service)
        except RtkitError as error:
            getLogger("rtkit.properties").warning("no zenoh for %s: %s", self._service.name, error)
        finally:
            for client in self._clients:
                client.close()

    def _stop(self) -> None:
        self._host.unregister(self._end, self)
        self._end.close()

    def close(self) -> None:
        """Wait for nobody any more; what is being opened is closed after this."""
        if self._opening is not None:
            self._opening.join()
            return
        self._stop()
        os.unlink(self._path)
