"""Values of properties as Python objects.

==============================  ============================================================
number                          ``int``, ``float``
boolean                         ``bool``
word                            `Word`
string                          ``str``
vector, list                    ``tuple``: a vector if it holds numbers only
element, marker                 `Element`
==============================  ============================================================

Source: `property-service` reference, section 3.
"""

from __future__ import annotations

from typing import TypeAlias, Union

Value: TypeAlias = Union[int, float, bool, "Word", str, "Element", tuple["Value", ...]]


class Word(str):
    """Name that is neither number nor boolean, and needs no quotes."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"Word({str.__repr__(self)})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Word) and str.__eq__(self, other)

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = str.__hash__


class Element:
    """Piece of XML: attributes, and either children or one value, the leaf.

    Attributes:
        name: Of the tag.
        attributes: Text by name, in the order they were given.
        children: Elements, in the order they were given.
        leaf: The value it holds, None when it holds none or has children.
    """

    __slots__ = ("attributes", "children", "leaf", "name")

    def __init__(
        self,
        name: str,
        attributes: dict[str, str] | None = None,
        children: tuple[Element, ...] = (),
        leaf: Value | None = None,
    ) -> None:
        self.name = name
        self.attributes = attributes or {}
        self.children = tuple(children)
        # An empty text and no text are written alike, so they are the same.
        self.leaf = None if children or (type(leaf) is str and not leaf) else leaf

    def find(self, name: str, index: int = 0) -> Element | None:
        """Return the child of that name, the `index`-th of several, None if there is none."""
        named = [child for child in self.children if child.name == name]
        return named[index] if index < len(named) else None

    def _key(self) -> tuple[object, ...]:
        return self.name, tuple(self.attributes.items()), self.children, self.leaf, type(self.leaf)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Element) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        return f"Element({self.name!r}, {self.attributes!r}, {self.children!r}, {self.leaf!r})"


def is_number(value: object) -> bool:
    """Return whether a value is a number; true and false are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def is_vector(value: object) -> bool:
    """Return whether a value is a group of numbers only; the empty group is vector and list."""
    return isinstance(value, tuple) and all(map(is_number, value))


def kind_of(value: object) -> str:
    """Return the word for the type of a value."""
    if isinstance(value, bool):
        return "boolean"
    if isinstance(value, int | float):
        return "number"
    if isinstance(value, Word):
        return "word"
    if isinstance(value, str):
        return "string"
    if isinstance(value, Element):
        return "marker" if value.name == "marker" else "element"
    if isinstance(value, bytes):
        return "bytes"
    return "vector" if is_vector(value) else "list"
