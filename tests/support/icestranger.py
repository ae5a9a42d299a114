"""Client of an Ice endpoint that speaks the Ice protocol byte by byte, rightly or not."""

from __future__ import annotations

import socket
import struct

from rtkit.link import secret

BOUND_S = 30.0
_HELLO = b"IceP\1\0\1\0\3\0\x0e\0\0\0"


class Stranger:
    """Speaks the protocol of Ice, byte by byte."""

    def __init__(self, port: int | None) -> None:
        self.end = socket.create_connection(("127.0.0.1", port or 0), BOUND_S)
        assert self.read(len(_HELLO)) == _HELLO

    def __enter__(self) -> Stranger:
        return self

    def __exit__(self, *_: object) -> None:
        self.end.close()

    def read(self, size: int) -> bytes:
        data = b""
        while len(data) < size and (more := self.end.recv(size - len(data))):
            data += more
        return data

    def ask(self, operation: str, body: bytes, service: str = "robot", number: int = 1) -> None:
        mode = 0 if operation == "set" else 2
        head = struct.pack("<i", number) + string(service) + string("") + b"\0"
        self.message(0, head + string(operation) + bytes([mode, 0]) + _capsule(body))

    def message(self, kind: int, body: bytes, size: int | None = None) -> None:
        size = 14 + len(body) if size is None else size
        self.end.sendall(b"IceP\1\0\1\0" + bytes([kind, 0]) + struct.pack("<i", size) + body)

    def reply(self) -> bytes:
        head = self.read(14)
        return self.read(struct.unpack("<i", head[10:])[0] - 14) if head else b""

    def log_in(self) -> None:
        self.ask("get", string("nonce"), "door")
        told = self.reply()
        nonce = told[12 : 12 + told[11]].decode()
        known = secret.read()
        proof = f"{known.user} {known.proof(nonce)}"
        self.ask("set", string("identity") + string(proof) + b"\0\0", "door")
        assert self.reply()[4] == 0, "it is let in"

    def is_hung_up_on(self) -> bool:
        try:
            while self.end.recv(1 << 16):
                pass
        except ConnectionError:
            return True
        return True


def string(text: str | bytes) -> bytes:
    raw = text if isinstance(text, bytes) else text.encode()
    size = bytes([len(raw)]) if len(raw) < 255 else b"\xff" + struct.pack("<i", len(raw))
    return size + raw


def _capsule(body: bytes) -> bytes:
    return struct.pack("<i", 6 + len(body)) + b"\1\1" + body
