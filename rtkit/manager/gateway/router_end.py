"""Passes bytes between a client of a gateway and the router of the manager: a link of hosts.

Its other end is `rtkit.hosts.tls_connection`. A router does all that it is asked to, so a link
takes an administrator, whose certificate is looked at as long as the link lasts.
"""

from __future__ import annotations

import select
from collections.abc import Callable
from typing import Protocol

from rtkit.errors import Unreachable
from rtkit.link import unix
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop

_CHUNK = 1 << 16
_HIGH = 1 << 20
"""Bytes that wait for the router, above which no more is read from the client."""


class _Client(Protocol):
    @property
    def is_full(self) -> bool: ...

    def send_bytes(self, data: bytes) -> None: ...

    def close(self) -> None: ...


class RouterEnd(IOHandler):
    """Connection to the router of a manager, for one client.

    Args:
        host: Owner of the loop that calls it.
        path: Socket of the manager.
        client: Gets what comes; is closed when the router has hung up.

    Raises:
        Unreachable: The manager does not answer.
    """

    def __init__(self, host: PropertyEventLoop, path: str, client: _Client) -> None:
        self._host = host
        self._client = client
        self._out = bytearray()
        try:
            self._end = unix.connect(path)
        except OSError as error:
            raise Unreachable(f"the manager does not answer: {error.strerror}") from error
        self._end.setblocking(False)
        self.is_open = True
        host.register(self._end, self)

    @property
    def is_full(self) -> bool:
        """Return whether the router takes less than comes."""
        return len(self._out) > _HIGH

    def pass_on(self, data: bytes) -> None:
        """Send bytes of the client to the router."""
        self._out += data
        self._send()

    def ready(self, mask: int) -> None:
        """See `IOHandler.ready`."""
        if mask & select.EPOLLOUT:
            self._send()
        if mask & ~select.EPOLLOUT and self.is_open:
            self._guarded(self._receive)
        if self.is_open:
            self.await_room()

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`: what waits goes when the router takes it."""
        return None

    def await_room(self) -> None:
        """Wait for what the router says, if the client takes it, and for room for what waits."""
        self._host.await_room(self._end, reads=not self._client.is_full, writes=bool(self._out))

    def close(self) -> None:
        """Hang up."""
        if self.is_open:
            self.is_open = False
            self._host.unregister(self._end, self)
            self._end.close()

    def _receive(self) -> None:
        data = self._end.recv(_CHUNK)
        if not data:
            raise ConnectionError
        self._client.send_bytes(data)

    def _send(self) -> None:
        def send() -> None:
            while self._out:
                del self._out[: self._end.send(memoryview(self._out)[:_CHUNK].tobytes())]

        self._guarded(send)
        if self.is_open:
            self.await_room()

    def _guarded(self, work: Callable[[], object]) -> None:
        try:
            work()
        except BlockingIOError:
            return
        except OSError:
            self._client.close()
