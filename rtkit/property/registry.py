"""Registry of the names of a service: lists them, their children, and resolves each."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rtkit.property.codes import PropertyError
from rtkit.property.naming import EXTENSIONS, check_registrable
from rtkit.property.node import PropertyNode
from rtkit.property.property_spec import EMPTY_PLACE
from rtkit.property.values import Value, Word
from rtkit.property.writing import as_item

_WITH_FIELD = frozenset({"gui", "meta"})


class NameEntry(NamedTuple):
    """Property, or part of one, that a name stands for.

    Attributes:
        name: Of the property, or of the inner node, that the rest belongs to.
        node: The property, None for an inner node.
        path: Part of the value of the property.
        extension: Reserved extension that is asked for, empty for the value itself.
        field: Text behind the extension.
    """

    name: str
    node: PropertyNode | None
    path: tuple[str, ...] = ()
    extension: str = ""
    field: str = ""

    @property
    def full_name(self) -> str:
        """Return the name of the property, or of the part of its value."""
        return ".".join((self.name, *self.path))


class Registry:
    """All properties of one service."""

    def __init__(self) -> None:
        self.nodes: dict[str, PropertyNode] = {}
        self._children: dict[str, dict[str, None]] = {"": {}}
        self._listed: dict[str, str] = {}

    def add(self, node: PropertyNode) -> None:
        """Register a property under its name.

        Raises:
            PropertyError: ``conflict``: the name is taken or reserved; ``syntax``, ``too-large``.
        """
        name = node.name = check_registrable(node.name)
        if name in self.nodes:
            raise PropertyError("conflict", f"exists: {name}")
        self.nodes[name] = node
        self._listed.clear()
        children = self._children
        if "." not in name:
            children[""][name] = None
            return
        while name:
            parent, _, segment = name.rpartition(".")
            siblings = children.setdefault(parent, {})
            if segment in siblings:
                return
            siblings[segment] = None
            name = parent

    def remove(self, name: str, *, only: bool = False) -> list[PropertyNode]:
        """Take a name off, with all below it or alone; return the properties that are gone."""
        if only and name in self.nodes and self.is_inner(name):
            return [self.nodes.pop(name)]
        gone = [self.nodes.pop(each) for each in [name, *self.below(name)] if each in self.nodes]
        if not gone:
            raise PropertyError("unknown", f"no such property: {name}")
        for each in [name, *self._inner(name)]:
            self._children.pop(each, None)
        self._listed.clear()
        while name:
            parent, _, segment = name.rpartition(".")
            self._children[parent].pop(segment, None)
            if not parent or self._children[parent] or parent in self.nodes:
                break
            del self._children[parent]
            name = parent
        return gone

    def _inner(self, name: str) -> list[str]:
        return [each for each in self.below(name) if each in self._children]

    def children(self, name: str) -> list[str]:
        """Return the names below a place, one level of them."""
        return list(self._children.get(name, ()))

    def below(self, name: str, depth: int | None = None) -> Iterator[str]:
        """Yield the names below a place, parents first, to a given depth; without recursion."""
        prefix = f"{name}." if name else ""
        stack = [(prefix + each, 1) for each in reversed(self.children(name))]
        while stack:
            full, level = stack.pop()
            yield full
            if depth is None or level < depth:
                below = self._children.get(full)
                if below:
                    stack.extend((f"{full}.{each}", level + 1) for each in reversed(below))

    def listed(self, name: str) -> str:
        """Return the list of the names below a place as text, written once."""
        text = self._listed.get(name)
        if text is None:
            text = f"({' '.join([as_item(each) for each in self._children.get(name, ())])})"
            self._listed[name] = text
        return text

    def is_inner(self, name: str) -> bool:
        """Return whether there are names below."""
        return bool(self._children.get(name)) or not name

    def find(self, name: str) -> NameEntry:
        """Return what a name stands for.

        The first that fits of: a property, an inner node, an extension of what is one of these,
        a part of the value of a property.

        Raises:
            PropertyError: ``unknown``.
        """
        node = self.nodes.get(name)
        if node is not None:
            return NameEntry(name, node)
        if name and self.is_inner(name):
            return NameEntry(name, None)
        segments = name.split(".")
        if segments[-2:] == ["properties", "listen"]:
            whose = self._valued(".".join(segments[:-2]))
            if whose is not None:
                return whose._replace(extension="listen", field="properties")
        for back in (1, 2):
            if len(segments) < back or segments[-back] not in EXTENSIONS:
                continue
            if back == 2 and segments[-2] not in _WITH_FIELD:
                continue
            base = ".".join(segments[:-back])
            place = self._valued(base)
            if place is not None:
                field = segments[-1] if back == 2 else ""
                return place._replace(extension=segments[-back], field=field)
        place = self.part_of(segments)
        if place is None and segments[-1] == "stop":
            place = self._stopping(".".join(segments[:-1]))
        if place is None:
            while segments[1:] and segments[-1] in EXTENSIONS:
                segments.pop()
            raise PropertyError("unknown", f"no such property: {'.'.join(segments)}")
        return place

    def _stopping(self, name: str) -> NameEntry | None:
        """Return what stops all actions below a place, if there are any."""
        nodes = self.nodes
        has_actions = any(nodes[each].function for each in self.below(name) if each in nodes)
        return NameEntry(name, None, ("stop",)) if has_actions else None

    def _valued(self, name: str) -> NameEntry | None:
        node = self.nodes.get(name)
        if node is not None or self.is_inner(name):
            return NameEntry(name, node)
        return self.part_of(name.split("."))

    def part_of(self, segments: list[str]) -> NameEntry | None:
        """Return the part of the property of the longest prefix that is registered."""
        for end in range(len(segments) - 1, 0, -1):
            prefix = ".".join(segments[:end])
            node = self.nodes.get(prefix)
            if node is not None:
                if node.spec is EMPTY_PLACE:
                    return None  # it has no parts, and what is not below it may come
                return NameEntry(prefix, node, tuple(segments[end:]))
        return None


def as_value(name: str) -> Value:
    """Return a name as it stands in a list."""
    return Word(name) if as_item(name) == name else name
