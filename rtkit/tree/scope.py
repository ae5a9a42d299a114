"""Scope of an observer: one component, or everything that is, or comes, below a path."""

from __future__ import annotations

from typing import NamedTuple

from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.user_events import UserEvent
from rtkit.errors import Malformed
from rtkit.rtc.names import LOCAL, Path
from rtkit.tree.resolve import entry
from rtkit.tree.view import NodeKind, TreeNode, shown_path


class Scope(NamedTuple):
    """Scope of a path; everything, if nothing is set.

    Attributes:
        instance: The component that it names.
        process: The slave that it names.
        directory: The directory that it names, absolute.
        is_one_manager: It names a manager, or what is below one.
        is_one_host: It names this host, or what is below it.
    """

    instance: str = ""
    process: str = ""
    directory: str = ""
    is_one_manager: bool = True
    is_one_host: bool = True

    def covers(self, what: UserEvent | ComponentFacts, hostname: str) -> bool:
        """Return whether it covers a component, or an event of one, at the manager of a host."""
        if self.instance:
            return what.instance == self.instance
        if self.process:
            return what.process == self.process
        if self.directory:
            shown = (shown_path(name, hostname) for name in what.names)
            return any(path.startswith(f"{self.directory}/") for path in shown)
        return True


def scope_of(root: TreeNode, path: Path, hostname: str) -> Scope:
    """Return what a path is about.

    Raises:
        NotFound: Nothing is there.
        Malformed: It names a port.
    """
    if path.port is not None:
        raise Malformed(f"Not a component: {path.typed}")
    node = entry(root, path, hostname)
    if node.instance:
        return Scope(instance=node.instance)
    if node.is_slave:
        return Scope(process=node.process)
    if node.kind is NodeKind.MANAGER:
        return Scope()
    if node is root.children.get(LOCAL) and node.name != LOCAL:
        return Scope()  # the host of the manager that is asked, somewhere else
    if node.kind is NodeKind.DIRECTORY or (node.kind is NodeKind.HOST and node.name != LOCAL):
        return Scope(directory=node.path)
    return Scope(is_one_manager=False, is_one_host=node is not root)
