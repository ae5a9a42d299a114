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

from rtkit.errors import Refused, RtkitError
from rtkit.link import places, unix
from rtkit.link.folder_watch import FolderWatch
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
    path = places.check_socket_length(places.service_key_socket(service.name))
    try:
        folder = FolderWatch(places.runtime_dir())
    except Refused:  # the kernel has no more watches: nobody would tell of a manager
        folder = None
    # Only now: a manager that starts after this look is seen in the folder.
    if folder is None or hosts or places.owner(places.usual_manager()) is not None:
        from rtkit.wires.zenoh.endpoint import open_zenoh

        if folder is not None:
            folder.close()
        open_zenoh(host, service, hosts)
        return
    ZenohOnDemand(host, service, path, folder)


class ZenohOnDemand(IOHandler):
    """Socket in the place of a zenoh endpoint, and watch for a manager.

    Args:
        path: Of the socket; nobody else uses it, as the name of the service is taken.
        folder: Of the sockets of this user.
    """

    def __init__(
        self, host: PropertyEventLoop, service: PropertyProvider, path: str, folder: FolderWatch
    ) -> None:
        self._host = host
        self._service = service
        self._path = path
        self._folder = folder
        self._manager = os.path.basename(places.manager_socket(places.usual_manager()))
        self._end = unix.listen(path, backlog=_BACKLOG)
        self._end.setblocking(False)
        self._clients: list[socket.socket] = []
        self._opening: threading.Thread | None = None
        host.register(self._end, self)
        host.register(folder, self)
        host.at_end(self.close)

    def ready(self, mask: int) -> None:
        """See `IOHandler.ready`."""
        self._admit()
        has_manager = self._manager in self._folder.take()
        if (has_manager or self._clients) and self._opening is None:
            # Not on the loop: to load the library takes as long as hundreds of requests.
            self._opening = threading.Thread(target=self._open, name="zenoh", daemon=True)
            self._opening.start()

    def flush(self, now: float) -> None:
        """See `IOHandler.flush`."""

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
        for client in self._clients:
            client.close()

    def _stop(self) -> None:
        for end in (self._end, self._folder):
            self._host.unregister(end, self)
            end.close()

    def close(self) -> None:
        """Wait for nobody any more; what is being opened is closed after this."""
        if self._opening is not None:
            self._opening.join()
            return
        self._stop()
        os.unlink(self._path)
