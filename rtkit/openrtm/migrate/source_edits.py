"""Changes of a source by the places of its syntax tree, so that the rest stays as it is."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from typing import NamedTuple

from rtkit.openrtm.migrate.python2 import TOKEN


class Edit(NamedTuple):
    """A text in place of another one, by offsets in the UTF-8 of the source [bytes]."""

    begin: int
    end: int
    text: str


class Remark(NamedTuple):
    """Place that a person should look at."""

    line: int
    text: str


class SourcePlaces:
    """Offsets of expressions in the UTF-8 of a source."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._lines = [0]
        for line in data.split(b"\n"):
            self._lines.append(self._lines[-1] + len(line) + 1)

    def begin(self, node: ast.expr | ast.stmt | ast.alias) -> int:
        """Return where a part of the source begins."""
        return self._lines[node.lineno - 1] + node.col_offset

    def end(self, node: ast.expr | ast.stmt | ast.alias) -> int:
        """Return where a part of the source ends."""
        return self._lines[(node.end_lineno or 1) - 1] + (node.end_col_offset or 0)

    def text(self, node: ast.expr | ast.stmt) -> str:
        """Return a part of the source as it is written."""
        return self._data[self.begin(node) : self.end(node)].decode()

    def whole(self, node: ast.expr | ast.stmt | ast.alias, text: str) -> Edit:
        """Return the change of a part of the source as a whole."""
        return Edit(self.begin(node), self.end(node), text)

    def attribute(self, node: ast.Attribute, name: str) -> Edit:
        """Return the change of the name behind the dot."""
        end = self.end(node)
        return Edit(end - len(node.attr.encode()), end, name)

    def operator(self, node: ast.BinOp) -> Edit:
        """Return the change of a ``/`` into ``//``; there may be comments around it."""
        begin, end = self.end(node.left), self.begin(node.right)
        between = self._data[begin:end].decode("latin-1")
        bare = TOKEN.sub(lambda match: " " * len(match[0]), between)
        at = begin + bare.index("/")
        return Edit(at, at + 1, "//")


def with_edits(data: bytes, edits: Iterable[Edit]) -> str:
    """Return the UTF-8 of a source with changes; none of them is within another one."""
    for edit in sorted(set(edits), reverse=True):
        data = data[: edit.begin] + edit.text.encode() + data[edit.end :]
    return data.decode()
