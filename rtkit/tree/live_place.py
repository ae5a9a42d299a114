"""Parses paths of live properties: component, manager or host, and name: ``…/Motor0.rtc.state``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rtkit.errors import Refused
from rtkit.rtc.names import is_local_host, parse_path
from rtkit.tree.resolve import entry, zombie
from rtkit.tree.view import NodeKind, build

if TYPE_CHECKING:
    from rtkit.tree.live_properties import LiveProperties

_NODE = r"(.+?\.(?:rtc|mgr))(?:\.(.*))?"


def steps_of(path: str, cwd: str) -> list[str]:
    """Return the steps from the root of the tree on that a path leads through."""
    whole = path if path.startswith("/") else f"{cwd}/{path}"
    return [step for step in whole.split("/") if step not in ("", ".")]


def split(path: str, cwd: str) -> tuple[str, str]:
    """Return the absolute path of a component or manager, and the name of a property of it.

    The last step that ends a component's or manager's name ends the path; without one it is empty.
    """
    steps = steps_of(path, cwd)
    for index in reversed(range(len(steps))):
        match = re.fullmatch(_NODE, steps[index])
        if match is not None:
            rest = [match[2]] if match[2] else []
            name = ".".join([*rest, *steps[index + 1 :]])
            return "/" + "/".join([*steps[:index], match[1]]), name
    return "", ""


def name_of_host(path: str, cwd: str, hostname: str) -> str | None:
    """Return the name of a property of this host, None if a path is about something else."""
    first, *rest = steps_of(path, cwd) or [""]
    if is_local_host(first, hostname):
        return ".".join(rest)
    host, dot, name = first.partition(".")
    if dot and not rest and is_local_host(host, hostname):
        return name
    return None


def open_live(path: str, timeout_s: float) -> LiveProperties:
    """Connect to the manager that a component or manager is found through.

    Raises:
        NotFound: Nothing is there.
        Refused: A zombie, or a slave.
        Unreachable: The manager does not answer.
    """
    from rtkit.tree.connect import connect
    from rtkit.tree.live_properties import LiveProperties
    from rtkit.tree.place import manager_of

    where = parse_path(path)
    tree = connect(manager_of(where), timeout_s)
    try:
        listing = tree.listing()
        node = entry(build(listing), where, listing.host)
        if node.kind is NodeKind.ZOMBIE:
            raise zombie(node, where)
        if node.is_slave or node.kind not in (NodeKind.COMPONENT, NodeKind.MANAGER):
            raise Refused(f"Not a component or manager: {path}")
        return LiveProperties(tree, node.instance)
    except BaseException:
        tree.close()
        raise
