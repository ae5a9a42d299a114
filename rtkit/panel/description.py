"""Reads the ``<gui>`` of a service: one tree of widgets, whoever draws it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rtkit.property.codes import PropertyError
from rtkit.property.property_spec import Bounds, PropertySpec
from rtkit.property.reading import read
from rtkit.property.types import SIMPLE, parse_type
from rtkit.property.values import Element, Value, is_number, is_vector

_OWN = frozenset({"name", "type", "access", "argument", "default"})
"""Attributes that a component cannot change: they say what a property is."""


class Panel(NamedTuple):
    """Widget of a property or of an argument, or a group of widgets.

    Attributes:
        attributes: As the service states them.
        children: Widgets of what lies below.
        arguments: Widgets of the arguments of an action.
    """

    attributes: Mapping[str, str]
    children: tuple[Panel, ...] = ()
    arguments: tuple[Panel, ...] = ()

    @property
    def kind(self) -> str:
        """Return the word for how it is drawn."""
        return self.attributes.get("kind", "label")

    @property
    def name(self) -> str:
        """Return the name of the property in its service."""
        return self.attributes.get("name", "")

    @property
    def is_read_only(self) -> bool:
        """Return whether nothing can be set."""
        return self.attributes.get("access") == "r"

    @property
    def is_round(self) -> bool:
        """Return whether it stands for a service whose widgets are among those above."""
        return "round" in self.attributes

    def words(self, key: str) -> tuple[Value, ...]:
        """Return the items of an attribute that is a list."""
        value = _read(self.attributes.get(key, ""))
        return value if isinstance(value, tuple) else ()

    def texts(self, key: str) -> list[str]:
        """Return the items of an attribute that is a list, as texts."""
        return [str(each) for each in self.words(key)]

    def number(self, key: str, default: float) -> float:
        """Return an attribute that is a number."""
        value = _read(self.attributes.get(key, ""))
        return float(value) if is_number(value) else default  # type: ignore[arg-type]

    def bounds(self, key: str) -> Bounds | None:
        """Return an attribute that is the least and the greatest number."""
        value = _read(self.attributes.get(key, ""))
        return value if is_vector(value) and len(value) == 2 else None  # type: ignore[arg-type,return-value]

    @property
    def spec(self) -> PropertySpec:
        """Return what is declared of the property."""
        type_name = self.attributes.get("type", "any").partition("[")[0].partition("<")[0]
        minimum, maximum = self.number("min", float("nan")), self.number("max", float("nan"))
        return PropertySpec(
            parse_type(type_name if type_name in SIMPLE else "any"),
            self.attributes.get("access", "rw"),
            self.attributes.get("unit", ""),
            None if minimum != minimum else minimum,
            None if maximum != maximum else maximum,
            choices=self.words("choices"),
            warn=self.bounds("warn"),
            alarm=self.bounds("alarm"),
            doc=self.attributes.get("doc", ""),
        )

    def all(self) -> Iterator[Panel]:
        """Yield it and all widgets below it, in the order in which they are drawn."""
        yield self
        for each in self.children:
            yield from each.all()


def panel_of(element: Element) -> Panel:
    """Return the widgets that an element describes; names bound how deep it is."""
    made = [panel_of(each) for each in element.children if each.name == "gui"]
    arguments = tuple(each for each in made if each.attributes.get("argument") == "true")
    children = tuple(each for each in made if each not in arguments)
    return Panel(dict(element.attributes), children, arguments)


def element_of(panel: Panel) -> Element:
    """Return the element that describes widgets."""
    below = (element_of(each) for each in (*panel.arguments, *panel.children))
    return Element("gui", dict(panel.attributes), tuple(below))


def read_panel(text: str) -> Panel:
    """Read the text of an element.

    Raises:
        PropertyError: ``syntax``: it is no ``<gui>``.
    """
    value = read(text)
    if not isinstance(value, Element) or value.name != "gui":
        raise PropertyError("syntax", "0 expected <gui>")
    return panel_of(value)


def dressed(panel: Panel, component: Panel) -> Panel:
    """Return widgets as a component wants them drawn.

    Its attributes stand for theirs, and its children, named from there, choose and order them.
    """
    changed = {key: text for key, text in component.attributes.items() if key not in _OWN}
    chosen = panel.children
    if component.children:
        prefix = f"{panel.name}." if panel.name else ""
        known = {each.name: each for each in panel.all()}
        pairs = [(known.get(prefix + each.name), each) for each in component.children]
        chosen = tuple(dressed(found, each) for found, each in pairs if found is not None)
    return panel._replace(attributes={**panel.attributes, **changed}, children=chosen)


def _read(text: str) -> Value:
    try:
        return read(text)
    except PropertyError:
        return text
