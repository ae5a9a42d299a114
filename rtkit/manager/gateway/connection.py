"""Client of a gateway: it asks for what its role may, or is a link to the router of a manager."""

from __future__ import annotations

import select
from collections.abc import Callable
from math import inf
from time import monotonic

from rtkit.manager.gateway.router_end import RouterEnd
from rtkit.property.requests import PropertyRequest
from rtkit.wires.line.secure import SecureConnection

_MOST_UNDER_WAY = 32
"""Requests of one client that are passed on at a time."""
_CHUNK, _HIGH = 1 << 16, 1 << 20
"""Size of one read of a link, and of the data that may wait to be sent [bytes]."""


class GatewayConnection(SecureConnection):
    """Client of a gateway; the relay itself keeps the record of what it asks."""

    def audited(self, ask: PropertyRequest, service: str) -> PropertyRequest:
        """See `Requester.audited`."""
        return ask

    _router: RouterEnd | None = None
    _is_slowed = False
    _later: tuple[float, Callable[[], object]] = (inf, lambda: None)

    def do_at(self, moment: float, work: Callable[[], object]) -> None:
        """Have something done at a moment [s], unless the connection has ended by then."""
        self._later = (moment, work)
        self.wake()

    def join(self, path: str) -> None:
        """Be a link to the router of the manager at a socket, after what is answered now.

        Raises:
            Unreachable: The manager does not answer.
        """
        self._router = RouterEnd(self._host, path, self)

    def ready(self, mask: int) -> bool:
        """See `IOHandler.ready`."""
        if self._router is None:
            is_done = super().ready(mask)
            if self._is_slowed:
                self.wake()
            return is_done
        if mask & ~select.EPOLLOUT and (data := self._receive(_CHUNK)):
            self._router.pass_on(data)
        self._send()
        return False

    def send_bytes(self, data: bytes) -> None:
        """Send what the router says."""
        self._out += data
        self._send()

    @property
    def is_full(self) -> bool:
        """Return whether it takes less than the router says."""
        return len(self._out) > _HIGH

    def _send(self) -> None:
        super()._send()
        if self._router is not None and self._router.is_open:
            self._router.await_room()

    def close(self) -> None:
        """See `SocketClient.close`."""
        if self._router is not None:
            self._router.close()
        super().close()

    def _is_full(self) -> bool:
        if self._router is not None:
            return self._router.is_full
        # A client that reads no answers, of which each may be large, is asked for no further
        # request. One that asks too often waits: a script in a loop is to be slow, and not to fail.
        if self._wait_s() > 0:
            self._is_slowed = True  # until `_work` looks again: requests may be left in its buffer
            return True
        return self._order.waiting >= _MOST_UNDER_WAY or super()._is_full()

    def _work(self) -> None:
        self._is_slowed = False
        super()._work()

    def _wait_s(self) -> float:
        return self._pace.wait_s(monotonic()) if self.is_open and self._pace is not None else 0.0

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`."""
        moment, work = self._later
        if now >= moment and self.is_open:
            self._later = (inf, lambda: None)
            work()
        due = super().flush(now)
        due = min(due or inf, now + self._wait_s()) if self._is_slowed else due
        return due if self._later[0] == inf else min(due or inf, self._later[0])

    def record(self, what: str, result: str) -> None:
        """Put on record what the client has done, or tried to do."""
        if self.peer is not None:
            self._record(self.peer, what, result)
