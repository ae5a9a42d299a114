"""Tree view: folds the rows of a listing into the tree that commands walk.

A component shows at every name under which it is registered, and below its manager; a slave is a
directory below its master.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from enum import Enum
from time import monotonic

from rtkit.deployment.listing import Listing, ListingRow
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, MANAGER_SUFFIX, is_local_host


class NodeKind(Enum):
    """Kind of a node; the value is the letter that ``rtfind -t`` takes."""

    ROOT = "/"
    HOST = "n"
    DIRECTORY = "d"
    MANAGER = "m"
    COMPONENT = "c"
    ZOMBIE = "z"


class TreeNode:
    """An entry of the tree.

    Attributes:
        row: Row of a component in the listing; None for a directory.
        process: Name of the process behind a manager or slave; empty for others.
        trouble: Why that process does not answer; empty when it does. Of the root: why the
            manager in use did not.
        pid: Of the manager that reported a component; 0 for what is a directory.
    """

    __slots__ = ("children", "kind", "name", "parent", "pid", "process", "row", "trouble")

    def __init__(
        self,
        name: str,
        kind: NodeKind,
        row: ListingRow | None = None,
        process: str = "",
        trouble: str = "",
        pid: int = 0,
    ) -> None:
        self.name = name
        self.kind = kind
        self.row = row
        self.process = process
        self.trouble = trouble
        self.pid = pid
        self.parent: TreeNode | None = None
        self.children: dict[str, TreeNode] = {}

    def add(self, node: TreeNode) -> TreeNode:
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
    def instance(self) -> str:
        """Name of the component behind the entry; empty for what is a directory."""
        return "" if self.row is None else self.row.instance

    @property
    def is_directory(self) -> bool:
        """Return whether it may hold entries."""
        return self.row is None

    @property
    def is_slave(self) -> bool:
        """Return whether it is a manager below another one."""
        return (
            self.kind is NodeKind.MANAGER and self.parent is not None and self.parent.process != ""
        )

    @property
    def remark(self) -> str:
        """Return the note beside the state: ``signal 9``, ``stopped``, ``stand-in``.

        Of what is in Error, the exception and its line.
        """
        row = self.row
        if row is None:
            return self.trouble
        made = "stand-in" if row.is_stand_in else ""
        if row.zombie:
            return ", ".join(filter(None, (row.zombie, row.coming(monotonic()), made)))
        return ", ".join(filter(None, (row.trouble, row.cause, row.again, made)))

    def entries(self) -> list[TreeNode]:
        """Return what is directly below, by name."""
        return [self.children[name] for name in sorted(self.children)]

    def walk(self) -> Iterator[TreeNode]:
        """Yield this node and everything below it, depth first."""
        yield self
        for child in self.entries():
            yield from child.walk()


def silent(nodes: Iterable[TreeNode]) -> list[TreeNode]:
    """Return those managers and hosts of which nothing is known, because they do not answer."""
    return [node for node in nodes if node.trouble and not node.is_slave and not node.children]


def once(nodes: Iterable[TreeNode]) -> list[TreeNode]:
    """Return nodes with each component once: by a name if it has one, else below its manager."""
    found: dict[object, TreeNode] = {}
    for node in nodes:
        key = (node.pid, node.instance) if node.instance else node
        if key not in found or _rank(node) < _rank(found[key]):
            found[key] = node
    return list(found.values())


def _rank(node: TreeNode) -> tuple[bool, int]:
    is_below_manager = node.parent is not None and node.parent.kind is NodeKind.MANAGER
    return is_below_manager, node.path.count("/")


def build(listing: Listing) -> TreeNode:
    """Return the root of the tree that `listing` describes."""
    root = TreeNode("", NodeKind.ROOT)
    root.add(TreeNode(LOCAL, NodeKind.HOST))
    for name in listing.names:
        parent, leaf = _parent(root, name, listing.host)
        if parent is not None:
            own = TreeNode(leaf, NodeKind.MANAGER, process=listing.manager, trouble=listing.trouble)
            _fill(parent.add(own), listing)
    for row in listing.rows:
        for name in row.names:
            parent, leaf = _parent(root, name, listing.host)
            if parent is not None:
                parent.add(_leaf(leaf, row, listing.pid))
    return root


def manager_node(listing: Listing, slave: str = "") -> TreeNode | None:
    """Return the manager that answered, whatever its names, or a slave of it; None without one."""
    path = f"{LOCAL}/{listing.manager}{MANAGER_SUFFIX}"
    host = build(listing._replace(names=(path,))).children[LOCAL]
    node = host.children[listing.manager + MANAGER_SUFFIX]
    return node.children.get(slave + MANAGER_SUFFIX) if slave else node


def shown_path(name: str, hostname: str, place: str = LOCAL) -> str:
    """Return where a registered name shows in the tree of a manager on the host `hostname`.

    Paths here begin with the `place` of that host.
    """
    host, slash, rest = name.partition("/")
    return f"/{place if is_local_host(host, hostname) else host}{slash}{rest}"


def _fill(manager: TreeNode, listing: Listing) -> None:
    """Put slaves and components below the manager, components below their slave too."""
    slaves = {
        name: manager.add(
            TreeNode(
                name + MANAGER_SUFFIX,
                NodeKind.MANAGER,
                process=name,
                trouble=_trouble(state, reason),
            )
        )
        for name, state, reason in listing.slaves
    }
    for row in listing.rows:
        manager.add(_leaf(row.instance + COMPONENT_SUFFIX, row, listing.pid))
        slave = slaves.get(row.process)
        if slave is not None:
            slave.add(_leaf(row.instance + COMPONENT_SUFFIX, row, listing.pid))


def _trouble(state: str, reason: str) -> str:
    if state in ("up", "silent"):
        return reason
    return f"{state}: {reason}" if reason and reason != state else state


def _parent(root: TreeNode, name: str, hostname: str) -> tuple[TreeNode | None, str]:
    """Return the directory that a registered name is in, and its last element."""
    host, slash, rest = name.partition("/")
    if not slash:
        return None, ""
    *directories, leaf = rest.split("/")
    node = _below(root, LOCAL if is_local_host(host, hostname) else host, NodeKind.HOST)
    for directory in directories:
        node = _below(node, directory, NodeKind.DIRECTORY)
    return node, leaf


def _below(node: TreeNode, name: str, kind: NodeKind) -> TreeNode:
    return node.children.get(name) or node.add(TreeNode(name, kind))


def _leaf(name: str, row: ListingRow, pid: int) -> TreeNode:
    return TreeNode(name, NodeKind.ZOMBIE if row.zombie else NodeKind.COMPONENT, row, pid=pid)
