"""Paths to nodes of the tree, with the errors that users know."""

from __future__ import annotations

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.names import LOCAL, Path, is_local_host
from rtkit.tree.view import Kind, Node


def find(root: Node, path: Path, hostname: str) -> Node | None:
    """Return the node at `path`, or None; `hostname` is the machine that ``localhost`` means."""
    node: Node | None = root
    for depth, element in enumerate(path.elements):
        name = LOCAL if depth == 0 and is_local_host(element, hostname) else element
        node = node.children.get(name) if node is not None else None
    return node


def entry(root: Node, path: Path, hostname: str) -> Node:
    """Return the node at `path`, which a trailing slash makes a directory.

    Raises:
        NotFound: Nothing is there.
    """
    node = find(root, path, hostname)
    if node is None or (path.is_directory and not node.is_directory):
        raise NotFound(f"No such object: {path.typed}")
    return node


def component(root: Node, path: Path, hostname: str) -> Node:
    """Return the living component at `path`, which must not name a port.

    Raises:
        NotFound: Nothing is there.
        Malformed: A port, or something with a trailing slash.
        Refused: A directory, a manager or a zombie.
    """
    check_component_syntax(path)
    return _living(find(root, path, hostname), path)


def component_of_port(root: Node, path: Path, hostname: str) -> Node:
    """Return the living component whose port `path` names.

    Raises:
        NotFound: Nothing is there.
        Refused: A directory, a manager or a zombie.
    """
    if path.is_directory:
        raise NotFound(f"No such object: {path.typed}")
    return _living(find(root, path, hostname), path)


def check_component_syntax(path: Path) -> None:
    """Refuse a path that by its form names no component.

    Raises:
        Malformed: It has a port or a trailing slash.
    """
    if path.port is not None or path.is_directory:
        raise Malformed(f"Not a component: {path.typed}")


def manager(root: Node, path: Path, hostname: str) -> Node:
    """Return the manager at `path`; a trailing slash is ignored.

    Raises:
        NotFound: Nothing is there.
        Refused: Something else, or a zombie.
    """
    node = find(root, path, hostname)
    if node is None:
        raise NotFound(f"No such object: {path.typed}")
    if node.kind is Kind.ZOMBIE:
        raise Refused(f"Zombie object: {path.typed}")
    if node.kind is not Kind.MANAGER or path.port is not None:
        raise Refused(f"Not a manager: {path.typed}")
    return node


def _living(node: Node | None, path: Path) -> Node:
    if node is None:
        raise NotFound(f"No such object: {path.typed}")
    if node.kind is Kind.ZOMBIE:
        raise Refused(f"Zombie object: {path.typed}")
    if node.kind is not Kind.COMPONENT:
        raise Refused(f"Not a component: {path.typed}")
    return node
