"""Rows of a listing folded into the tree that commands walk.

A component shows at every name under which it is registered, and below its manager; a slave is a
directory below its master.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum

from rtkit.deployment.listing import Listing, Row
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, MANAGER_SUFFIX, is_local_host


class Kind(Enum):
    """What stands behind a node; the value is the letter that ``rtfind -t`` takes."""

    ROOT = "/"
    HOST = "n"
    DIRECTORY = "d"
    MANAGER = "m"
    COMPONENT = "c"
    ZOMBIE = "z"


class Node:
    """An entry of the tree."""

    __slots__ = ("children", "kind", "name", "parent", "row")

    def __init__(self, name: str, kind: Kind, row: Row | None = None) -> None:
        self.name = name
        self.kind = kind
        self.row = row
        self.parent: Node | None = None
        self.children: dict[str, Node] = {}

    def add(self, node: Node) -> Node:
        """Put `node` below this one and return it."""
        node.parent = self
        self.children[node.name] = node
        return node

    @property
    def path(self) -> str:
        """Absolute path, ``/`` for the root."""
        names: list[str] = []
        node = self
        while node.parent is not None:
            names.append(node.name)
            node = node.parent
        return "/" + "/".join(reversed(names))

    @property
    def is_directory(self) -> bool:
        """Whether it may hold entries."""
        return self.row is None

    def walk(self) -> Iterator[Node]:
        """Yield this node and everything below it, depth first."""
        yield self
        for child in self.children.values():
            yield from child.walk()


def build(listing: Listing) -> Node:
    """Return the root of the tree that `listing` describes."""
    root = Node("", Kind.ROOT)
    local = root.add(Node(LOCAL, Kind.HOST))
    manager = local.add(Node(listing.manager + MANAGER_SUFFIX, Kind.MANAGER))
    slaves = {
        name: manager.add(Node(name + MANAGER_SUFFIX, Kind.MANAGER)) for name, *_ in listing.slaves
    }
    for row in listing.rows:
        _place(root, row, listing.host)
        manager.add(_leaf(row.instance + COMPONENT_SUFFIX, row))
        slave = slaves.get(row.process)
        if slave is not None:
            slave.add(_leaf(row.instance + COMPONENT_SUFFIX, row))
    return root


def _place(root: Node, row: Row, hostname: str) -> None:
    for name in row.names:
        host, *directories, leaf = name.split("/")
        node = _below(root, LOCAL if is_local_host(host, hostname) else host, Kind.HOST)
        for directory in directories:
            node = _below(node, directory, Kind.DIRECTORY)
        node.add(_leaf(leaf, row))


def _below(node: Node, name: str, kind: Kind) -> Node:
    return node.children.get(name) or node.add(Node(name, kind))


def _leaf(name: str, row: Row) -> Node:
    return Node(name, Kind.ZOMBIE if row.zombie else Kind.COMPONENT, row)
