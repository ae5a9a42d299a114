"""Client behind a socket of an endpoint: reads requests, sends replies as the client takes them."""

from __future__ import annotations

from time import monotonic

from rtkit.serving.event_loop import ByteStream, IOHandler, PropertyEventLoop
from rtkit.serving.quota import EndpointQuota, SubscribingClient

_MOST_AT_ONCE = 1 << 18
"""Bytes that are sent in one go."""


class SocketClient(IOHandler, SubscribingClient):
    """Client behind a socket, or behind something that behaves as one.

    Args:
        host: Host whose loop serves it.
        end: The socket.
        quota: How much there is room for, and what may be done.

    Attributes:
        is_open: Until the socket is closed.
    """

    def __init__(
        self, host: PropertyEventLoop, end: ByteStream, quota: EndpointQuota, identity: str = ""
    ) -> None:
        super().__init__(quota, identity)
        self.is_open = True
        self._host = host
        self._end = end
        self._pace = quota.pace()
        self._longest = quota.limits.size
        self._out = bytearray()
        self._is_working = False
        self._is_closing = False
        self._moved_at = monotonic()
        self._mask = (True, False)
        end.setblocking(False)
        host.register(end, self)

    def wake(self) -> None:
        """See `Requester.wake`."""
        if self.is_open:
            self._host.mark(self)

    def _receive(self, size: int) -> bytes:
        """Return what has come, at most so many bytes; a client that has gone is closed."""
        try:
            data = self._end.recv(size)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self.close()
        return data

    def _send_out(self) -> bool:
        """Send what waits, as far as it is taken; return whether the client is still there."""
        out = self._out
        while out and self.is_open:
            try:
                sent = self._end.send(
                    out if len(out) <= _MOST_AT_ONCE else memoryview(out)[:_MOST_AT_ONCE]
                )
            except BlockingIOError:
                break
            except OSError:
                self.close()
                break
            self._moved_at = monotonic()
            del out[:sent]
        return self.is_open

    def _await(self, *, reads: bool) -> None:
        """Wait until it can be read, if so wished, and until it takes what is to be sent."""
        mask = (reads, bool(self._out))
        if mask != self._mask:
            self._host.await_room(self._end, reads=mask[0], writes=mask[1])
            self._mask = mask

    def close(self) -> None:
        """Forget the client and whatever it listens to."""
        if not self.is_open:
            return
        self.is_open = False
        self._host.unregister(self._end, self)
        self._end.close()
        for service in self._host.services.values():
            service.forget(self)
