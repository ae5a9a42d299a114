"""Which manager a path leads to, and what else there is to be shown beside the one that is asked."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rtkit.errors import RtkitError
from rtkit.link.places import manager_socket
from rtkit.rtc.address import is_address
from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX, Path, is_local_host
from rtkit.tree.client import DEFAULT_MANAGER, connect
from rtkit.tree.view import Kind, Node, build, manager_node

if TYPE_CHECKING:
    from rtkit.tree.client import Tree


def manager_of(path: Path) -> str:
    """Return the manager that a path is below, as `connect` takes it; empty for the usual one.

    That is the one at ``host:port``, or another one of this host by ``/localhost/NAME.mgr``.
    """
    if not path.elements:
        return ""
    host = path.elements[0]
    if is_address(host):
        return host
    if len(path.elements) < 2 or not path.elements[1].endswith(MANAGER_SUFFIX):
        return ""
    name = path.elements[1].removesuffix(MANAGER_SUFFIX)
    usual = os.environ.get("RTKIT_MANAGER") or DEFAULT_MANAGER
    if name == usual or not is_local_host(host, os.uname().nodename):
        return ""
    return name if os.path.exists(manager_socket(name)) else ""


def servers() -> list[str]:
    """Return the addresses that are always to be in the tree (``RTKIT_SERVERS``)."""
    given = os.environ.get("RTKIT_SERVERS") or os.environ.get("RTCTREE_NAMESERVERS") or ""
    return [address for address in map(str.strip, given.split(";")) if is_address(address)]


def add_others(root: Node, tree: Tree, path: Path, *, is_deep: bool) -> None:
    """Put the other managers of this host, and the servers, into a tree where `path` shows them.

    What they hold is asked only if it is wanted (`is_deep`); who does not answer is marked.
    """
    if len(path.elements) > 1:
        return
    if not path.elements:
        for address in servers():
            root.add(_server(address, tree.timeout_s, is_deep=is_deep))
    local = root.children.get(LOCAL)
    if local is not None and (not path.elements or not is_address(path.elements[0])):
        for name in _others(tree.manager):
            if name + MANAGER_SUFFIX not in local.children:
                local.add(_neighbour(name, tree.timeout_s, is_deep=is_deep))


def _others(manager: str) -> Iterator[str]:
    from rtkit.link.running import managers

    return (name for name in managers() if name != manager)


def _neighbour(name: str, timeout_s: float, *, is_deep: bool) -> Node:
    trouble = ""
    if is_deep:
        try:
            with connect(name, timeout_s) as tree:
                node = manager_node(tree.listing())
            if node is not None:
                return node
        except RtkitError as error:
            trouble = str(error)
    return Node(name + MANAGER_SUFFIX, Kind.MANAGER, process=name, trouble=trouble)


def _server(address: str, timeout_s: float, *, is_deep: bool) -> Node:
    trouble = ""
    if is_deep:
        try:
            with connect(address, timeout_s) as tree:
                node = build(tree.listing()).children[LOCAL]
            node.name = address
            return node
        except RtkitError as error:
            trouble = str(error)
    return Node(address, Kind.HOST, trouble=trouble)
