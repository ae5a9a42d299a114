"""Fast path: answers the most frequent kind of request lines as bytes, with the least work.

That is ``GET name`` or ``SET name value``, with nothing else to it, of a property that is kept
here or is a plain attribute. Everything else goes the long way, `Service.handle`, which comes to
the same.

See decisions 34 and 92.
"""

from __future__ import annotations

from rtkit.property.codes import PropertyError
from rtkit.property.live_values import LiveValues
from rtkit.property.node import PropertyNode
from rtkit.property.requests import Requester
from rtkit.property.user_code import Unfolded

_MOST_KNOWN = 4096
"""Lines, and names of properties, that are known as bytes."""


class FastPath:
    """Fast path to the properties of a service."""

    def __init__(self, values: LiveValues) -> None:
        self._value_of = values.value_of
        self._set_plain = values.set_plain
        self._nodes = values.registry.nodes
        self._lines: dict[bytes, PropertyNode] = {}
        self._names: dict[bytes, PropertyNode] = {}

    def reply(self, line: bytes, caller: Requester) -> bytes | None:
        """Return the reply to a whole request line, None if it has to go the long way."""
        node = self._lines.get(line)
        if node is None:
            if line[:4] == b"SET ":
                return self._set(line, caller)
            node = self._found(self._lines, line, line[4:-1]) if line[:4] == b"GET " else None
        if node is None or not caller.may("GET", node.name):
            return None
        if node.reader is not None and not self._is_read(node):
            return None
        return None if node.value is None else node.line or None

    def _is_read(self, node: PropertyNode) -> bool:
        """Have a property hold its present value, unless that calls user code, or fails."""
        if node.is_quick is None or "r" not in node.spec.access or not node.is_quick():
            return False
        try:
            self._value_of(node)
        except (PropertyError, Unfolded):
            return False
        return True

    def _set(self, line: bytes, caller: Requester) -> bytes | None:
        name, blank, raw = line[4:-1].partition(b" ")
        node = self._names.get(name) or self._found(self._names, name, name)
        if node is None or not blank or node.function is not None or not raw.isascii():
            return None
        if node.reader is None and node.writer is None:
            if node.value is None:
                return None
        elif node.is_quick is None or not node.is_quick():
            return None
        text = raw.decode("ascii")
        if text[:1] == "{" or text[-1:] == "\r" or not caller.may("SET", node.name):
            return None
        try:
            self._set_plain(node, text)
        except Unfolded:
            return None
        except PropertyError as error:
            return f"! {error.code} {error}\n".encode("utf-8", "replace")
        return b"=\n"

    def _found(
        self, known: dict[bytes, PropertyNode], key: bytes, name: bytes
    ) -> PropertyNode | None:
        node = self._nodes.get(name.decode("latin-1"))
        if node is not None:
            if len(known) >= _MOST_KNOWN:
                known.clear()
            known[key] = node
        return node

    def forget(self) -> None:
        """Look every name up anew: some have gone."""
        self._lines.clear()
        self._names.clear()
