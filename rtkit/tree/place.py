"""Finds the manager that a path leads to, and the others to be shown beside it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from rtkit.errors import RtkitError, Unreachable
from rtkit.link.host_links import hosts, is_linked
from rtkit.link.places import DEFAULT_MANAGER, host_name, manager_socket, usual_manager
from rtkit.rtc.manager_address import is_address
from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX, Path, is_local_host
from rtkit.tree.client import DEFAULT_TIMEOUT_S
from rtkit.tree.connect import connect
from rtkit.tree.view import NodeKind, TreeNode, build, manager_node

if TYPE_CHECKING:
    from rtkit.deployment.listing import Listing
    from rtkit.tree.client import Tree


_Answer = TypeVar("_Answer")
_PART_FOR_OTHERS = 0.4
"""Part of the time-out that other managers and hosts may take: those that do not answer are named
within 5 s."""


def manager_of(path: Path) -> str:
    """Return the manager that a path is below, as `connect` takes it; empty for the usual one.

    That is the one at ``host:port``, one of a linked host, or another one of this host by
    ``/localhost/…/NAME.mgr``.
    """
    if not path.elements:
        return ""
    host = path.elements[0]
    if is_address(host):
        return host
    named = (each for each in path.elements[1:] if each.endswith(MANAGER_SUFFIX))
    name = next(named, "").removesuffix(MANAGER_SUFFIX)
    if not is_local_host(host, host_name()):
        return f"{host}/{name}" if is_linked(host) else ""
    if name in ("", usual_manager()):
        return ""
    return name if os.path.exists(manager_socket(name)) else ""


def is_far_address(host: str) -> bool:
    """Return whether a step of a path is the address of a manager on another host."""
    return is_address(host) and not is_local_host(host, host_name())


def is_on_another_host(path: Path) -> bool:
    """Return whether a path leads to a linked host, or to the address of a manager elsewhere."""
    host = path.elements[0] if path.elements else ""
    return is_far_address(host) or (
        bool(host) and not is_local_host(host, host_name()) and is_linked(host)
    )


def servers() -> list[str]:
    """Return the addresses that are always to be in the tree (``RTKIT_SERVERS``)."""
    return [each for each in _servers()[1] if is_address(each)]


def strange_servers() -> list[str]:
    """Return why entries of ``RTKIT_SERVERS`` are not in the tree: they are no addresses."""
    variable, entries = _servers()
    return [f"{variable}: not HOST:PORT: {each!r}" for each in entries if not is_address(each)]


def _servers() -> tuple[str, list[str]]:
    """Return the variable that names servers, and its entries."""
    variable = "RTKIT_SERVERS" if os.environ.get("RTKIT_SERVERS") else "RTCTREE_NAMESERVERS"
    entries = os.environ.get(variable, "").split(";")
    return variable, [each for each in map(str.strip, entries) if each]


def others(tree: Tree) -> list[str]:
    """Return the managers that are known beside the present one, each as `connect` takes it."""
    return [*_others(tree.manager), *servers()]


def silent_servers(timeout_s: float) -> list[str]:
    """Return why those do not answer that are always to be in the tree; all are asked at once."""
    asked = [partial(_why_silent, address, timeout_s) for address in servers()]
    return list(filter(None, _at_once(asked)))


def _why_silent(address: str, timeout_s: float) -> str:
    try:
        connect(address, timeout_s).close()
    except RtkitError as error:
        return str(error)
    return ""


def root_for(tree: Callable[[], Tree], path: Path, *, is_deep: bool) -> tuple[TreeNode, str]:
    """Return the tree as far as `path` shows it, and the host that ``localhost`` means.

    Raises:
        Unreachable: The manager does not answer, and there is nobody else to be shown.
    """
    try:
        asked = tree()
        listing = asked.listing()
    except Unreachable as error:
        root = _without_manager(path, str(error), is_deep=is_deep)
        if root is None:
            raise
        return root, host_name()
    root = build(listing)
    if path.elements and manager_of(path).partition("/")[1]:
        root.children[LOCAL].name = listing.host
        return root, listing.host
    if path.elements and is_far_address(path.elements[0]):
        root.children[LOCAL].name = path.elements[0]
        return root, listing.host
    add_others(root, asked, path, is_deep=is_deep)
    return root, listing.host


def _without_manager(path: Path, trouble: str, *, is_deep: bool) -> TreeNode | None:
    """Return what there is beside the usual manager, which is in trouble; None if nothing is.

    On its own host only if it does not run: one that hangs is to be reported.
    """
    hostname = host_name()
    host, *below = path.elements or [LOCAL]
    if not is_local_host(host, hostname):
        return None
    root = TreeNode("", NodeKind.ROOT, trouble=trouble * is_missed())
    local = root.add(TreeNode(LOCAL, NodeKind.HOST, trouble=trouble))
    running = list(_others(""))
    if usual_manager() not in running:
        if count := _add_services(local):
            local.trouble += f"; services: {count}"
        for node in _at_once(_of(_neighbour, running, None, is_deep=is_deep)):
            local.add(node)
    if not path.elements:
        for node in _at_once(_of(_server, servers(), None, is_deep=is_deep)):
            root.add(node)
    place: TreeNode | None = local
    for step in below:  # only above services there is anything without a manager
        place = place.children.get(step) if place else None
    if below and (place is None or place.kind is not NodeKind.DIRECTORY):
        return None
    return root if local.children or len(root.children) > 1 else None


def is_missed() -> bool:
    """Return whether the usual manager is missed if it does not run.

    Nobody misses the default one where only services or managers of other names were started.
    """
    is_chosen = bool(os.environ.get("RTKIT_MANAGER"))
    return is_chosen or os.path.lexists(manager_socket(DEFAULT_MANAGER))


def add_others(root: TreeNode, tree: Tree, path: Path, *, is_deep: bool) -> None:
    """Put the other managers of this host, and the servers, into a tree where `path` shows them.

    What they hold is asked only if it is wanted (`is_deep`); who does not answer is marked.
    """
    is_here = not path.elements or not is_address(path.elements[0])
    local = root.children.get(LOCAL)
    if local is not None and is_here:
        _add_services(local)
    if len(path.elements) > 1:
        return
    asked: list[Callable[[], TreeNode]] = []
    if not path.elements:
        asked += _of(_server, [*servers(), *hosts()], tree, is_deep=is_deep)
    far = len(asked)
    if local is not None and is_here:
        known = local.children
        names = [name for name in _others(tree.manager) if name + MANAGER_SUFFIX not in known]
        asked += _of(_neighbour, names, tree, is_deep=is_deep)
    for number, node in enumerate(_at_once(asked)):
        if number < far or local is None:
            root.add(node)
            continue
        local.add(node)
        if node.trouble and not path.elements:
            local.trouble = "; ".join(filter(None, (local.trouble, node.trouble)))


def _of(
    ask: Callable[..., TreeNode], names: Iterable[str], tree: Tree | None, *, is_deep: bool
) -> list[Callable[[], TreeNode]]:
    """Return what sends a request to each, bounded by a part of the present time-out."""
    bound_s = _PART_FOR_OTHERS * (tree.timeout_s if tree else DEFAULT_TIMEOUT_S)
    return [partial(ask, name, bound_s, is_deep=is_deep) for name in names]


def _at_once(asked: Sequence[Callable[[], _Answer]]) -> list[_Answer]:
    """Ask all at the same time, so that one who does not answer costs no more than its time."""
    if len(asked) < 2:
        return [ask() for ask in asked]
    from threading import Thread

    answers: dict[int, _Answer] = {}

    def ask_one(number: int) -> None:
        answers[number] = asked[number]()

    threads = [Thread(target=ask_one, args=(number,)) for number in range(len(asked))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return [answers[number] for number in sorted(answers)]


def _add_services(host: TreeNode) -> int:
    """Show the property services of this user as directories; return how many there are."""
    from rtkit.link.places import services as sockets

    if not sockets():
        return 0
    from rtkit.link.running import services

    living = services()
    for name in living:
        node = host
        for step in name.split("/"):
            node = node.children.get(step) or node.add(TreeNode(step, NodeKind.DIRECTORY))
    return len(living)


def _others(manager: str) -> Iterator[str]:
    from rtkit.link.running import managers

    return (name for name in managers() if name != manager)


def _neighbour(name: str, timeout_s: float, *, is_deep: bool) -> TreeNode:
    bare = TreeNode(name + MANAGER_SUFFIX, NodeKind.MANAGER, process=name)
    return _with_content(bare, name, manager_node, timeout_s) if is_deep else bare


def _server(address: str, timeout_s: float, *, is_deep: bool) -> TreeNode:
    def named(listing: Listing) -> TreeNode:
        node = build(listing).children[LOCAL]
        node.name = address
        return node

    bare = TreeNode(address, NodeKind.HOST)
    where = address if is_address(address) else f"{address}/"
    return _with_content(bare, where, named, timeout_s) if is_deep else bare


def _with_content(
    bare: TreeNode, name: str, node_of: Callable[[Listing], TreeNode | None], timeout_s: float
) -> TreeNode:
    """Return the node with what the manager holds; where that cannot be asked, the bare one."""
    try:
        with connect(name, timeout_s) as tree:
            return node_of(tree.listing()) or bare
    except RtkitError as error:
        bare.trouble = str(error)
        return bare


def shown(name: str, manager: str, place: str) -> str:
    """Return the path that leads to a registered name of a manager that answered at a place.

    Empty if there is none: then the component is only found below its manager.
    """
    host, _, rest = name.partition("/")
    far, slash, _ = place.partition("/")
    if slash:
        return f"/{far}/{rest}"
    if is_far_address(place):
        return f"/{place}/{rest}"
    if manager == usual_manager() or not is_local_host(host, host_name()):
        return f"/{name}"
    return f"/{place}/{rest}" if is_address(place) else ""
