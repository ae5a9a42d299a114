"""Properties in a tree, as components of OpenRTM-aist describe and configure themselves with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any


class Properties:
    """A node of a tree of properties: a value, a default, and nodes below it.

    Args:
        key: Its name.
        value: Its value.
        defaults_map: Default values by dotted name.
        defaults_str: The same as names and values in turn, up to an empty name.
        num: How many entries of `defaults_str` count; negative for all.
        prop: A tree to copy.
    """

    def __init__(
        self,
        key: str | None = None,
        value: str | None = None,
        defaults_map: Mapping[str, str] | None = None,
        defaults_str: Sequence[str] | None = None,
        num: int | None = None,
        prop: Properties | None = None,
    ) -> None:
        self.name = key or ""
        self.value = value or ""
        self.default_value = ""
        self.root: Properties | None = None
        self.leaf: list[Properties] = []
        if prop is not None:
            self.name, self.value, self.default_value = prop.name, prop.value, prop.default_value
            self.mergeProperties(prop)
        for name, text in (defaults_map or {}).items():
            self.setDefault(name, text)
        if defaults_str is not None:
            self.setDefaults(defaults_str, num)

    def getName(self) -> str:
        """Return its name."""
        return self.name

    def getValue(self) -> str:
        """Return its value."""
        return self.value

    def getDefaultValue(self) -> str:
        """Return its default."""
        return self.default_value

    def getLeaf(self) -> list[Properties]:
        """Return the nodes below it."""
        return self.leaf

    def getRoot(self) -> Properties | None:
        """Return the node above it."""
        return self.root

    def getProperty(self, key: str, default: str | None = None) -> str:
        """Return the value of a dotted name, else its default, else `default`."""
        node = self.findNode(key)
        found = (node.value or node.default_value) if node is not None else ""
        return found or default or ""

    def getDefault(self, key: str) -> str:
        """Return the default of a dotted name."""
        node = self.findNode(key)
        return node.default_value if node is not None else ""

    def setProperty(self, key: str, value: Any = None) -> str:
        """Set the value of a dotted name; return the former one."""
        node = self.getNode(key)
        former, node.value = node.value, "" if value is None else str(value)
        return former

    def setDefault(self, key: str, value: Any) -> str:
        """Set the default of a dotted name; return it."""
        node = self.getNode(key)
        node.default_value = str(value)
        return node.default_value

    def setDefaults(self, defaults: Sequence[str], num: int | None = None) -> None:
        """Set defaults, names and values in turn, up to an empty name."""
        given = list(defaults) if num is None or num < 0 else list(defaults)[:num]
        for key, value in zip(given[::2], given[1::2], strict=False):
            if not key.strip():
                break
            self.setDefault(key.strip(), value.strip())

    def load(self, lines: Any) -> None:
        """Read ``name: value`` lines."""
        for line in lines:
            text = line.strip()
            if text and text[0] not in "#!":
                key, _, value = text.partition(":" if ":" in text else "=")
                self.setProperty(key.strip(), value.strip())

    def store(self, out: Any, header: str) -> None:
        """Write ``name: value`` lines behind a comment."""
        out.write(f"#{header}\n")
        for name, text in self.texts().items():
            out.write(f"{name}: {text}\n")

    save = store

    def list(self, out: Any) -> None:
        """Write everything for people."""
        out.write(str(self))

    def propertyNames(self) -> Sequence[str]:
        """Return the dotted names of all nodes that have nothing below them."""
        return [name for name, _ in self._ends("")]

    def texts(self) -> dict[str, str]:
        """Return values, else defaults, by dotted name."""
        return {name: node.value or node.default_value for name, node in self._ends("")}

    def size(self) -> int:
        """Return how many names there are."""
        return len(self.propertyNames())

    def findNode(self, key: str) -> Properties | None:
        """Return the node of a dotted name; None where there is none."""
        node: Properties | None = self
        for name in filter(None, key.split(".")):
            node = node.hasKey(name) if node is not None else None
        return node if key else None

    def getNode(self, key: str) -> Properties:
        """Return the node of a dotted name, made where there was none."""
        node = self
        for name in filter(None, key.split(".")):
            below = node.hasKey(name)
            if below is None:
                below = Properties(name)
                below.root = node
                node.leaf.append(below)
            node = below
        return node

    def createNode(self, key: str) -> bool:
        """Make a node; return whether it was not there."""
        is_new = bool(key) and self.findNode(key) is None
        if is_new:
            self.getNode(key)
        return is_new

    def removeNode(self, leaf_name: str) -> Properties | None:
        """Remove a node right below this one; return it."""
        found = self.hasKey(leaf_name)
        if found is not None:
            self.leaf.remove(found)
        return found

    def hasKey(self, key: str) -> Properties | None:
        """Return the node of that name right below this one."""
        return next((each for each in self.leaf if each.name == key), None)

    def clear(self) -> None:
        """Remove everything below this node."""
        self.leaf.clear()

    def mergeProperties(self, prop: Properties) -> Properties:
        """Take over all values of another tree, and its defaults where this one has none."""
        for name, other in prop._ends(""):
            own = self.getNode(name)
            own.value = other.value or own.value
            own.default_value = own.default_value or other.default_value
        return self

    def _ends(self, prefix: str) -> Iterator[tuple[str, Properties]]:
        for each in self.leaf:
            name = f"{prefix}{each.name}"
            if each.leaf:
                yield from each._ends(f"{name}.")  # noqa: SLF001 - of this class
            if not each.leaf or each.value or each.default_value:
                yield name, each

    def __str__(self) -> str:
        return "".join(f"- {name}: {text}\n" for name, text in self.texts().items())
