"""Port here that leads to the sshd of another host: it may lead elsewhere, and cut connections."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress

_EVER = 1 << 40


class Forwarder:
    """A port that leads to another host.

    Attributes:
        port: Of this host.
        after: After how many bytes that go there a connection is cut.
    """

    def __init__(self, address: str, port: int = 22) -> None:
        self._to = (address, port)
        self.after = _EVER
        self._opened: list[socket.socket] = []
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.port = self._socket.getsockname()[1]
        threading.Thread(target=self._serve, daemon=True).start()

    def lead(self, port: int) -> None:
        """Lead new connections to another port there."""
        self._to = (self._to[0], port)

    def cut(self) -> None:
        """End all connections."""
        for each in self._opened:
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """End all, and listen no longer."""
        self._socket.shutdown(socket.SHUT_RDWR)
        self.cut()
        for each in (self._socket, *self._opened):
            each.close()

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                near, _ = self._socket.accept()
                far = socket.create_connection(self._to)
                self._opened += [near, far]
                for source, sink, most in ((near, far, self.after), (far, near, _EVER)):
                    words = (source, sink, most)
                    threading.Thread(target=self._pass, args=words, daemon=True).start()

    @staticmethod
    def _pass(source: socket.socket, sink: socket.socket, left: int) -> None:
        with suppress(OSError):
            while left > 0 and (data := source.recv(min(left, 1 << 16))):
                sink.sendall(data)
                left -= len(data)
        for each in (source, sink):
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
