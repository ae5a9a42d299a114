"""Asks the manager for a completion, and completes paths of the tree, level by level.

At most one request of each kind is made, and facts stay plain data. Only paths that a command can
take are completed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.cli.completion.candidates import Candidate, those
from rtkit.cli.shared.app import working_directory
from rtkit.deployment.listing import ListingRow
from rtkit.rtc.names import parse_path
from rtkit.tree.place import manager_of, root_for
from rtkit.tree.resolve import find
from rtkit.tree.view import NodeKind, TreeNode

if TYPE_CHECKING:
    from rtkit.rtc.names import Path
    from rtkit.tree.client import Tree


Plain = dict[str, Any]


class CompletionSource:
    """The tree that a path leads into.

    Facts are not decoded into records: importing those takes longer than all the rest.

    Attributes:
        timeout_s: Bound on each call [s].
    """

    def __init__(self, timeout_s: float, tree: Tree | None = None) -> None:
        self.timeout_s = timeout_s
        self._tree = tree
        self._is_own_tree = tree is None
        self._parts: dict[tuple[str, ...], Plain] = {}

    def tree(self, place: str = "") -> Tree:
        """Return the connection to a manager, the one that was asked for first.

        Raises:
            Unreachable: It does not run, or does not answer in time.
        """
        if self._tree is None:
            from rtkit.tree.connect import connect

            self._tree = connect(place, self.timeout_s)
        return self._tree

    def folder(self, typed: str) -> TreeNode | None:
        """Return the entries at a path as typed, as far as the next level shows them."""
        return self._at(parse_path(typed, working_directory()))

    def component(self, typed: str) -> TreeNode | None:
        """Return the component, or the manager, that a path names, with or without a port."""
        return self._at(parse_path(typed, working_directory())._replace(port=None))

    def _at(self, path: Path) -> TreeNode | None:
        root, host = root_for(lambda: self.tree(manager_of(path)), path, is_deep=False)
        return find(root, path, host)

    def ports(self, instance: str) -> list[Plain]:
        """Return the ports of a component."""
        return list(self.facts(instance).get("ports", ()))

    def facts(self, instance: str) -> Plain:
        """Return the facts of a component, none when there is none of that name."""
        return next(
            (each for each in self.part(instance)["components"] if each["instance"] == instance), {}
        )

    def part(self, *instances: str) -> Plain:
        """Return the facts about components; with none, about the manager itself."""
        if instances not in self._parts:
            self._parts[instances] = _whole(self.tree().plain(instances))
        return self._parts[instances]

    @cached_property
    def snapshot(self) -> Plain:
        """A snapshot of everything that the manager knows."""
        return _whole(self.tree().plain())

    def close(self) -> None:
        """End the connection that was made here."""
        if self._is_own_tree and self._tree is not None:
            self._tree.close()
            self._tree = None


def _whole(facts: Plain) -> Plain:
    """Return facts with the lists that are left out when empty."""
    return {"components": [], "connectors": [], "modules": [], "properties": {}, **facts}


def instances_of(wires: Sequence[Plain], instance: str, port: str | None) -> list[Plain]:
    """Return those connectors that end at a component, or at one port of it."""
    return [
        connector
        for connector in wires
        if any(
            end["instance"] == instance and (port is None or end["port"] == port)
            for end in connector["ports"]
        )
    ]


PortFits = Callable[[str, Plain], bool]
"""Tells of an instance name and a port of it, as plain facts, whether it is meant."""


class WantedPath(NamedTuple):
    """Condition on the entry that a path leads to.

    Attributes:
        fits: Tells of an entry whether it can be named; of directories with a slash behind.
        takes_folders: Whether a directory itself can be named, whatever is in it.
        has_port: Whether a port must follow; None when it may.
        port_fits: Ports that are meant.
    """

    fits: Callable[[TreeNode], bool]
    takes_folders: bool = False
    has_port: bool | None = False
    port_fits: PortFits = lambda _instance, _port: True


def paths(live: CompletionSource, typed: str, wanted: WantedPath) -> list[Candidate]:
    """Return the ways to go on with a path: the next level, or the ports of a component."""
    head, slash, rest = typed.rpartition("/")
    if not typed and working_directory() == "/":
        slash = "/"
    above = head + slash
    if ":" in rest and not (head == "" and rest.partition(":")[2][:1].isdigit()):
        name, _, start = rest.partition(":")
        return _ports(live, f"{above}{name}", start, wanted) if wanted.has_port is not False else []
    folder = live.folder(above or ".")
    if folder is None or not folder.is_directory:
        return []
    found = [
        candidate
        for child in folder.entries()
        if child.name.startswith(rest)
        for candidate in _ways(child, above, wanted)
    ]
    if len(found) == 1 and found[0].text.endswith(":"):
        return _ports(live, found[0].text[:-1], "", wanted) or found
    return found


def _ways(node: TreeNode, above: str, wanted: WantedPath) -> Iterator[Candidate]:
    is_component = node.row is not None and node.kind is NodeKind.COMPONENT
    about = node.row.state if node.row is not None and is_component else node.kind.name.lower()
    if not node.is_directory:
        if wanted.fits(node):
            yield Candidate(f"{above}{node.name}{':' * (wanted.has_port is True)}", about)
        return
    if wanted.fits(node):
        yield Candidate(f"{above}{node.name}", about)
    if wanted.takes_folders or _leads_on(node, wanted):
        yield Candidate(f"{above}{node.name}/", about)


def _leads_on(node: TreeNode, wanted: WantedPath) -> bool:
    # Another manager is only asked when the path leads to it: each costs a connection.
    is_unknown = not node.children and node.kind in (NodeKind.MANAGER, NodeKind.HOST)
    below = (each for each in node.walk() if each is not node)
    return (is_unknown and not node.is_slave) or any(wanted.fits(each) for each in below)


def _ports(live: CompletionSource, path: str, start: str, wanted: WantedPath) -> list[Candidate]:
    node = live.component(path)
    if node is None or node.row is None:
        return []
    instance = node.row.instance
    ports = (port for port in live.ports(instance) if wanted.port_fits(instance, port))
    return [
        candidate
        for port in ports
        for candidate in those([f"{path}:{port['name']}"], f"{path}:{start}", described(port))
    ]


def described(port: Plain) -> str:
    """Return the description of a port in a few words: ``DataInPort TimedLong``."""
    name = port.get("properties", {}).get("dataport.data_type", "")
    return f"{port['port_type']} {name.removeprefix('IDL:').removesuffix(':1.0')}".rstrip()


def living(node: TreeNode) -> bool:
    """Return whether it is a component that somebody is behind."""
    return node.kind is NodeKind.COMPONENT


def in_state(state: str) -> Callable[[TreeNode], bool]:
    """Return a predicate: whether a living component is in that state."""
    return lambda node: living(node) and node.row is not None and node.row.state == state


def with_row(test: Callable[[ListingRow], bool]) -> Callable[[TreeNode], bool]:
    """Return a predicate: whether the row of a living component passes a test."""
    return lambda node: living(node) and node.row is not None and test(node.row)
