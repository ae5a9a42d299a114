"""Nodes that YAML and JSON have in common: tables, lists and scalars, with their lines.

Scalars stay text: the tables of `rtkit.profile.spec` know the type of each of them, so ``0.2``
is a version where a version is meant, and ``no`` a name where a name is.
"""

from __future__ import annotations

from typing import NamedTuple

from rtkit.profile.findings import refused

MAX_DEPTH = 136
"""Tables and lists nested deeper than this are refused; an element may be both of them."""

MAX_NODES = 450_000
"""A document of more scalars, tables and lists than this is refused."""

_MARKS = (
    (b"\xff\xfe\0\0", "utf-32"),
    (b"\0\0\xfe\xff", "utf-32"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
)
_NULLS = ("", "~", "null", "Null", "NULL")


class ScalarNode(NamedTuple):
    """A scalar; one that is not quoted may stand for something else than text."""

    line: int
    text: str
    is_quoted: bool = False

    @property
    def is_null(self) -> bool:
        """Return whether nothing is there."""
        return not self.is_quoted and self.text in _NULLS


class TableNode(NamedTuple):
    """Keys and their values, in the order of the document; each key is there once."""

    line: int
    items: tuple[tuple[ScalarNode, Node], ...]


class ListNode(NamedTuple):
    """A list."""

    line: int
    items: tuple[Node, ...]


Node = ScalarNode | TableNode | ListNode


def decoded(data: bytes, source: str) -> str:
    """Return the text of a document: UTF-8, or what its byte order mark says.

    Raises:
        InvalidProfile: It is no such text.
    """
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), "utf-8-sig")
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        name = encoding.removesuffix("-sig").upper()
        raise refused(
            source, line, "not-well-formed", f"not {name}: byte {error.start + 1}"
        ) from error
