"""Describes the widgets of a property, or of a whole service, as ``.gui`` shows them.

What draws them, in a terminal or a browser, needs nothing else: each has its name, type and access,
and in it are those of what lies below, and of the arguments of an action. Values are not in it.

Source: `property-service` reference, section 7.
"""

from __future__ import annotations

from rtkit.property import components
from rtkit.property.codes import PropertyError
from rtkit.property.live_values import LiveValues
from rtkit.property.node import PropertyNode
from rtkit.property.presenting import EMPTY
from rtkit.property.property_spec import PropertySpec, RequestParameter
from rtkit.property.registry import NameEntry
from rtkit.property.requests import Requester
from rtkit.property.types import Content, parse_type
from rtkit.property.values import Element, is_vector, kind_of
from rtkit.property.writing import write

_KINDS = {
    "boolean": "toggle",
    "number": "number",
    "integer": "number",
    "vector": "vector",
    "list": "table",
    "marker": "marker",
    "element": "tree",
    "bytes": "label",
}
_OF_READERS = frozenset({"map", "marker", "table", "tree", "vector"})
"""Kinds that are drawn also where nothing can be set."""
_OF_BEHAVIORS = frozenset({"any", "element", "marker"})
_IMAGES = frozenset({"image", "picture", "photo"})


def gui(values: LiveValues, place: NameEntry, caller: Requester) -> Element:
    """Return the widget of a property or of a part of one, or the tree of all below a place."""
    if place.node is None or not place.path:
        return _Tree(values, caller).of(place.name)
    spec = place.node.spec
    part = components.get(_value(place.node), place.path, spec.labels)  # type: ignore[arg-type]
    made = PropertySpec(parse_type(kind_of(part)), spec.access, spec.unit, spec.minimum,
                        spec.maximum, spec.step)  # fmt: skip
    return widget(place.full_name, made, _access(made, place.name, caller), part)


class _Tree:
    """Widgets of a service as one caller may see them."""

    def __init__(self, values: LiveValues, caller: Requester) -> None:
        self._values = values
        self._registry = values.registry
        self._caller = caller

    def of(self, name: str) -> Element:
        """Return the widget of a name, with those of all below; names are at most so deep."""
        node = self._registry.nodes.get(name)
        prefix = f"{name}." if name else ""
        names = [prefix + each for each in self._registry.children(name)]
        below = [self.of(each) for each in names if self._caller.may("GET", each)]
        if node is None:
            types = self._types(f"{prefix}type")
            attributes = {"kind": "group", "name": name, **_own(self._spec(None, name))}
            if types.startswith("("):
                attributes["type"] = types
            return Element("gui", attributes, tuple(below))
        spec = self._spec(node, name)
        access = _access(spec, name, self._caller)
        made = widget(name, spec, access, _value(node))
        if node.returning is not None and "kind" not in spec.widget:
            made.attributes |= {"kind": "joystick", "after": write(node.returning.after)}
        function = node.function
        arguments = function.parameters if function is not None else ()
        if made.attributes["kind"] == "button" and function is None:
            target = RequestParameter("target", parse_type("marker"))
            arguments = (target,)  # of a behaviour, which a SET of its target starts
        children = (*map(_argument, arguments), *below)
        return Element("gui", made.attributes, children)

    def _types(self, name: str) -> str:
        """Return what a property says of which types its owner is, empty where it is not there."""
        nodes = self._registry.nodes
        own = nodes.get(name) or self._values.standard.nodes.get(name)
        try:
            return "" if own is None else str(self._values.payload_of(NameEntry(name, own), {}))
        except PropertyError:
            return ""

    def _spec(self, node: PropertyNode | None, name: str) -> PropertySpec:
        """Return what is declared; without what code tells that fails, for the others go on."""
        try:
            return self._values.spec_of(node, name)
        except PropertyError:
            return EMPTY if node is None else node.spec


def _value(node: PropertyNode) -> Content | None:
    return node.value if node.function is None else None


def _access(spec: PropertySpec, name: str, caller: Requester) -> str:
    if caller.may("SET", name):
        return "rw" if spec.is_functional else spec.access
    return "r"


def _argument(declared: RequestParameter) -> Element:
    spec = declared.spec or PropertySpec(declared.type, choices=declared.choices, doc=declared.doc)
    made = widget(declared.key, spec, "rw", None)
    more = {"argument": "true"}
    if declared.default is not None:
        more["default"] = write(declared.default)
    return Element("gui", {**made.attributes, **more})


def widget(name: str, spec: PropertySpec, access: str, value: Content | None) -> Element:
    """Return the widget of a property, from what is declared of it and the value that it has."""
    numbers = {"min": spec.minimum, "max": spec.maximum, "step": spec.step}
    labels = _labels(spec, value)
    doc = next(iter(spec.doc.strip().splitlines()), "")
    attributes = {
        "kind": _kind(name, spec, access, value),
        **{key: write(each) for key, each in numbers.items() if each is not None},
        "unit": spec.unit,
        "choices": write(spec.choices) if spec.choices else "",
        "name": name,
        "type": "" if spec.is_functional else spec.type.name,
        "access": access,
        "warn": write(spec.warn) if spec.warn else "",
        "alarm": write(spec.alarm) if spec.alarm else "",
        "labels": f"({' '.join(labels)})" if labels else "",
        "doc": doc,
    } | _own(spec)
    return Element("gui", {key: text for key, text in attributes.items() if text})


def _own(spec: PropertySpec) -> dict[str, str]:
    """Return the attributes that are declared, and which forms there are."""
    forms = {"forms": f"({' '.join(spec.gui)})"} if spec.gui else {}
    return forms | dict(spec.widget)


def _kind(name: str, spec: PropertySpec, access: str, value: Content | None) -> str:
    """Return the kind of widget that suits a property."""
    if spec.is_functional:
        return "button"
    base = spec.type.base
    if name.split(".")[-2:-1] == ["behaviors"] and "w" in access and base in _OF_BEHAVIORS:
        return "button"
    if base == "any" and value is not None:
        base = kind_of(value)
    kind = _KINDS.get(base, "text")
    item = spec.type.item
    if base == "list" and item is not None and item.base == "marker":
        kind = "map"
    if base == "bytes" and name.rpartition(".")[2] in _IMAGES:
        return "image"
    if access == "r":
        return kind if kind in _OF_READERS else "label"
    if spec.choices:
        return "choice"
    is_bounded = spec.minimum is not None and spec.maximum is not None
    return "slider" if kind == "number" and is_bounded else kind


def _labels(spec: PropertySpec, value: Content | None) -> list[str]:
    if spec.type.size is not None:
        value = (0.0,) * spec.type.size
    return components.names(value, spec.labels) if is_vector(value) else []
