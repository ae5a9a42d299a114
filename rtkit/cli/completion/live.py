"""Requests to the manager for a completion: at most one of each kind, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rtkit.cli.shared.app import working_directory
from rtkit.rtc.names import parse_path
from rtkit.tree.place import manager_of, root_for
from rtkit.tree.resolve import find
from rtkit.tree.view import TreeNode

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
