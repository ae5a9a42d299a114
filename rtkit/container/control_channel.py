"""Messages between manager, zygote and slaves: JSON behind a length, over private sockets."""

from __future__ import annotations

import json
import select
import socket
import struct

from rtkit.deployment.message import Message
from rtkit.errors import Malformed
from rtkit.rtc.serde import parse_table

_HEADER = struct.Struct("<I")
_to_json = json.JSONEncoder(separators=(",", ":")).encode
MAX_MESSAGE = 64 * 1024 * 1024


class ControlChannel:
    """One end of a private socket; on a non-blocking one `send` keeps what does not fit yet."""

    def __init__(self, connection: socket.socket) -> None:
        self.socket = connection
        self._received = bytearray()
        self._outbox = bytearray()

    def fileno(self) -> int:
        """Return the descriptor, for selectors."""
        return self.socket.fileno()

    @property
    def has_backlog(self) -> bool:
        """Return whether bytes wait for `flush`."""
        return bool(self._outbox)

    @property
    def is_over(self) -> bool:
        """Return whether the other end is closed, even if not all it sent has been received."""
        poll = select.poll()
        poll.register(self.socket, 0)
        return bool(poll.poll(0))

    def send(self, message: Message) -> None:
        """Send one message.

        Raises:
            OSError: The other end is gone.
        """
        payload = _to_json(message).encode()
        self._outbox += _HEADER.pack(len(payload)) + payload
        self.flush()

    def flush(self) -> None:
        """Send what waits, as far as the other end takes it."""
        try:
            while self._outbox:
                sent = self.socket.send(self._outbox)
                del self._outbox[:sent]
        except BlockingIOError:
            return

    def forget_backlog(self) -> None:
        """Drop what waits for `flush`: the other end is gone."""
        self._outbox.clear()

    def receive(self) -> list[Message] | None:
        """Wait for bytes and return the messages that they complete; None when the other closed.

        Raises:
            Malformed: The bytes are no message.
        """
        try:
            chunk = self.socket.recv(1 << 18)
        except BlockingIOError:
            return []
        except ConnectionResetError:
            return None
        if not chunk:
            return None
        self._received += chunk
        messages: list[Message] = []
        while len(self._received) >= _HEADER.size:
            (size,) = _HEADER.unpack_from(self._received)
            if size > MAX_MESSAGE:
                raise Malformed(f"message of {size} bytes")
            end = _HEADER.size + size
            if len(self._received) < end:
                break
            messages.append(parse_table(bytes(self._received[_HEADER.size : end])))
            del self._received[:end]
        return messages

    def close(self) -> None:
        """Close this end."""
        self.socket.close()
