"""Resolves paths to nodes of the tree, and raises the errors that users know."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Protocol, TypeVar

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.manager_address import is_address
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, MANAGER_SUFFIX, Path, is_local_host
from rtkit.tree.view import NodeKind, TreeNode, build

if TYPE_CHECKING:
    from rtkit.deployment.listing import Listing

Node = TypeVar("Node")
_FEW = 50
"""For more paths the whole listing is asked for at once."""


class Listings(Protocol):
    """Source of listings: a `Tree`."""

    def listing(self) -> Listing:
        """Return the short list of components."""
        ...

    def listing_at(self, paths: Sequence[Path]) -> Listing:
        """Return one with the components at a few paths."""
        ...


def nodes_at(
    asked: Listings, paths: Sequence[Path], how: Callable[[TreeNode, Path, str], Node]
) -> list[Node]:
    """Return what `how`, a function of this module, finds at each path.

    Only what is at these paths is asked for. Where that does not do, the whole listing is, so that
    an error tells what may have been meant.
    """
    if len(paths) <= _FEW:
        try:
            found = _nodes(asked.listing_at(paths), paths, how)
        except (NotFound, Refused, Malformed):
            found = []
        if found and None not in found:
            return found
    return _nodes(asked.listing(), paths, how)


def node_at(asked: Listings, path: Path, how: Callable[[TreeNode, Path, str], Node]) -> Node:
    """Return what `how` finds at one path; see `nodes_at`."""
    return nodes_at(asked, [path], how)[0]


def _nodes(
    listing: Listing, paths: Sequence[Path], how: Callable[[TreeNode, Path, str], Node]
) -> list[Node]:
    root = build(listing)
    return [how(root, path, listing.host) for path in paths]


def find(root: TreeNode, path: Path, hostname: str) -> TreeNode | None:
    """Return the node at `path`, or None; `hostname` is the machine that ``localhost`` means."""
    node: TreeNode | None = root
    for depth, element in enumerate(path.elements):
        name = _first(root, element, hostname) if depth == 0 else element
        node = node.children.get(name) if node is not None else None
    return node


def _first(root: TreeNode, host: str, hostname: str) -> str:
    """Return the name of a host in a tree: the one asked at an address is the local one there."""
    if is_local_host(host, hostname):
        return LOCAL
    return LOCAL if host not in root.children and is_address(host) else host


def absent(root: TreeNode, path: Path, hostname: str) -> NotFound:
    """Return the error that nothing is at `path`, with what may have been meant by it."""
    node = root
    for depth, element in enumerate(path.elements):
        name = _first(root, element, hostname) if depth == 0 else element
        below = node.children.get(name)
        if below is None:
            meant = _base_is_gone(path, depth) or _meant(path, element, node)
            meant = meant or (_below_local(path, root) if depth == 0 else "")
            if depth == 0 and not meant and path.typed.startswith("/"):
                return no_such_host(path.typed, element, root.children)
            return NotFound(f"No such object: {path.typed}{meant}")
        node = below
    return NotFound(f"No such object: {path.typed}")


def no_such_host(typed: str, host: str, there: Iterable[str] = ()) -> NotFound:
    """Return the error that a path leads to no host that is linked.

    Args:
        typed: The path, as the user typed it.
        host: Its first element.
        there: Hosts in the tree.
    """
    from rtkit.link.host_links import hosts
    from rtkit.settings import inventory_files

    known, linked = inventory_files.names(), hosts()
    if host in linked or host.endswith((COMPONENT_SUFFIX, MANAGER_SUFFIX)):
        return NotFound(f"No such object: {typed}")
    if host in known:
        return NotFound(f"{typed}: host {host} is not linked (rtmgr start --host {host} links it)")
    hint = inventory_files.hint(host, {*known, *linked, *there})
    return NotFound(f"{typed}: no such host: {host}{hint}")


def present(root: TreeNode, path: Path, hostname: str) -> TreeNode:
    """Return the node at `path`, with a trailing slash or without.

    Raises:
        NotFound: Nothing is there.
    """
    node = find(root, path, hostname)
    if node is None:
        raise absent(root, path, hostname)
    return node


def _base_is_gone(path: Path, depth: int) -> str:
    """Return a hint if what is missing is not in what was typed, but in what it goes from."""
    steps = [step for step in path.typed.split("/") if step not in ("", ".")]
    base = path.elements[: len(path.elements) - len(steps)]
    if path.typed.startswith("/") or ".." in steps or depth >= len(base):
        return ""
    return f" (the working directory /{'/'.join(base)} is not there: rtcwd, RTKIT_CWD change it)"


def _meant(path: Path, element: str, node: TreeNode) -> str:
    from rtkit.rtc.nearest import did_you_mean

    head, found, tail = path.typed.rpartition(element)
    if not found or ":" in element:
        return ""
    word = _stem(element)
    known = {_stem(child.name): child.name for child in node.entries()}
    # Motor1, asked for where there is Motor0, is not mistyped.
    apart = [each for each in known if each == word or _letters(each) != _letters(word)]
    return did_you_mean(word, apart, 1, lambda stem: f"{head}{known[stem]}{tail}")


def _below_local(path: Path, root: TreeNode) -> str:
    """Return a hint if what was typed is there, but below this host, which was left out."""
    local, element = root.children.get(LOCAL), path.elements[0]
    below = local.entries() if local is not None else ()
    name = next((each.name for each in below if _stem(each.name) == _stem(element)), "")
    _, found, tail = path.typed.partition(element)
    return f" (did you mean /{LOCAL}/{name}{tail}?)" if name and found else ""


def _stem(name: str) -> str:
    return name.removesuffix(COMPONENT_SUFFIX).removesuffix(MANAGER_SUFFIX)


def _letters(stem: str) -> str:
    return "".join(c for c in stem if not c.isdigit())


def no_port(path: Path, ports: Iterable[str]) -> NotFound:
    """Return the error that a component has no such port, with what may have been meant by it."""
    from rtkit.rtc.nearest import did_you_mean

    return NotFound(f"Port not found: {path.typed}{did_you_mean(path.port or '', ports)}")


def entry(root: TreeNode, path: Path, hostname: str) -> TreeNode:
    """Return the node at `path`, which a trailing slash makes a directory.

    Raises:
        NotFound: Nothing is there.
    """
    node = present(root, path, hostname)
    if path.is_directory and not node.is_directory:
        raise absent(root, path, hostname)
    return node


def component(root: TreeNode, path: Path, hostname: str) -> TreeNode:
    """Return the living component at `path`, which must not name a port.

    Raises:
        NotFound: Nothing is there.
        Malformed: A port, or something with a trailing slash.
        Refused: A directory, a manager or a zombie.
    """
    check_component_syntax(path)
    return _living(root, path, hostname)


def supervised(root: TreeNode, path: Path, hostname: str) -> TreeNode:
    """Return the component at `path`: it lives, or its policy has it in hand after its end.

    Raises:
        NotFound: Nothing is there.
        Malformed: A port, or something with a trailing slash.
        Refused: A directory, a manager, or a zombie that stays one.
    """
    check_component_syntax(path)
    node = find(root, path, hostname)
    if node is not None and node.row is not None and node.row.is_in_hand:
        return node
    return _living(root, path, hostname)


def zombie(node: TreeNode, path: Path) -> Refused:
    """Return the error that nobody is behind `path` any more, with why."""
    return Refused(f"Zombie object: {path.typed} ({node.remark})")


def component_of_port(root: TreeNode, path: Path, hostname: str) -> TreeNode:
    """Return the living component whose port `path` names.

    Raises:
        NotFound: Nothing is there.
        Refused: A directory, a manager or a zombie.
    """
    if path.is_directory:
        raise absent(root, path, hostname)
    return _living(root, path, hostname)


def check_component_syntax(path: Path) -> None:
    """Refuse a path that by its form names no component.

    Raises:
        Malformed: It has a port or a trailing slash.
    """
    if path.port is not None or path.is_directory:
        raise Malformed(f"Not a component: {path.typed}")


def manager(root: TreeNode, path: Path, hostname: str) -> TreeNode:
    """Return the manager at `path`; a trailing slash is ignored.

    Raises:
        NotFound: Nothing is there.
        Refused: Something else, or a zombie.
    """
    node = present(root, path, hostname)
    if node.kind is NodeKind.ZOMBIE:
        raise zombie(node, path)
    if node.kind is not NodeKind.MANAGER or path.port is not None:
        raise Refused(f"Not a manager: {path.typed}{_managers_below(node, path)}")
    return node


def _managers_below(node: TreeNode, path: Path) -> str:
    """Return a hint with the managers of a host whose own path was typed."""
    if path.port is not None or len(path.elements) != 1:
        return ""
    below = [name for name, each in node.children.items() if each.kind is NodeKind.MANAGER]
    typed = path.typed.rstrip("/")
    return f" (did you mean {' or '.join(f'{typed}/{name}' for name in below)}?)" if below else ""


def _living(root: TreeNode, path: Path, hostname: str) -> TreeNode:
    node = present(root, path, hostname)
    if node.kind is NodeKind.ZOMBIE:
        raise zombie(node, path)
    if node.kind is not NodeKind.COMPONENT:
        raise Refused(f"Not a component: {path.typed}")
    return node
