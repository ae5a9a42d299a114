"""Request lines of the kind that most are, answered as bytes with as little as it takes.

That is ``GET name`` or ``SET name value``, with nothing else to it, of a property that is kept
here. Everything else goes the long way, `Service.handle`, which comes to the same.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.property.codes import PropertyError

if TYPE_CHECKING:
    from rtkit.property.messages import Caller
    from rtkit.property.node import Node
    from rtkit.property.service import Service

_MOST_KNOWN = 4096
"""Names of properties that are known as bytes."""


class Quick:
    """The short way to the properties of a service."""

    def __init__(self, service: Service) -> None:
        self._service = service
        self._known: dict[bytes, Node] = {}

    def reply(self, line: bytes, caller: Caller) -> bytes | None:
        """Return the reply to a whole request line, None if it has to go the long way."""
        is_get = line.startswith(b"GET ")
        end = len(line) - 1 if is_get else line.find(b" ", 4)
        if end < 0:
            return None
        name = line[4:end]
        node = self._known.get(name) or self._found(name)
        if node is None or node.reader is not None or node.value is None:
            return None
        if is_get:
            return (node.line or None) if caller.may("GET", node.name) else None
        raw = line[end + 1 : -1]
        is_odd = raw[:1] == b"{" or raw[-1:] == b"\r" or not raw.isascii()
        is_plain = node.writer is None and node.function is None and line.startswith(b"SET ")
        if is_odd or not is_plain or not caller.may("SET", node.name):
            return None
        try:
            self._service.set_plain(node, raw.decode("ascii"))
        except PropertyError as error:
            return f"! {error.code} {error}\n".encode("utf-8", "replace")
        return b"=\n"

    def _found(self, raw: bytes) -> Node | None:
        node = self._service.registry.nodes.get(raw.decode("latin-1"))
        if node is not None:
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            self._known[raw] = node
        return node

    def forget(self) -> None:
        """Look every name up anew: some have gone."""
        self._known.clear()
