"""Maps parts of a model to their positions in the document."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from rtkit.profile.findings import Findings
from rtkit.profile.spec import Child, ElementSpec


class Position(NamedTuple):
    """A line of a document, and the XPath of an element or attribute."""

    line: int
    path: str


class Positions:
    """Positions of the parts of one model, in the tree that the model was built from."""

    def __init__(self, root: Any, spec: ElementSpec, found: Findings) -> None:
        self._root = root
        self._spec = spec
        self._found = found
        self._children: dict[Any, dict[str, list[tuple[Any, ElementSpec | None]]]] = {}

    def position(self, steps: Sequence[tuple[str, int]], field: str = "") -> Position:
        """Return where the part is to which fields of the model lead, each with its number.

        `field` is an attribute of that part. What the document does not hold is where it would
        be: at the nearest part around it.
        """
        element, spec = self._root, self._spec
        for name, number in steps:
            below = self._below(element, spec).get(name, [])
            if number >= len(below) or below[number][1] is None:
                break
            element, inner = below[number]
            spec = inner if inner is not None else spec
        names = (each.name for each in spec.attributes if each.field == field)
        attribute = next((each for each in names if element.get(each) is not None), None)
        return Position(self._found.line(element), self._found.path(element, attribute))

    def _below(
        self, element: Any, spec: ElementSpec
    ) -> dict[str, list[tuple[Any, ElementSpec | None]]]:
        known = self._children.get(element)
        if known is None:
            known = {}
            for item in element:
                slot: tuple[int, Child] | None = spec.index.get(item.tag)
                if slot is not None:
                    known.setdefault(slot[1].field, []).append((item, slot[1].spec))
            self._children[element] = known
        return known
