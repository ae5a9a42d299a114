"""Builds ``.meta`` of a property: its declaration, and the state of its value."""

from __future__ import annotations

from rtkit.property.codes import PropertyError
from rtkit.property.live_values import LiveValues, part
from rtkit.property.node import PropertyNode
from rtkit.property.registry import NameEntry
from rtkit.property.requests import Requester
from rtkit.property.user_code import result_of
from rtkit.property.values import Element, Value, Word, kind_of
from rtkit.property.writing import write


def meta(
    values: LiveValues, place: NameEntry, caller: Requester, *, calls_user_code: bool = True
) -> Element:
    """Return the element; for a part of a value it has the type of that part.

    Args:
        values: Of the service.
        place: The property, or the part of one.
        caller: Requester; properties that it may not set are shown as read-only.
        calls_user_code: It is read anew even where that takes user code.

    Raises:
        PropertyError: ``unknown``: there is no such part.
    """
    node = place.node
    assert node is not None
    spec = values.spec_of(node, "") if calls_user_code else node.spec
    kind = spec.type.name
    if node.function is not None:
        kind = "element"
    elif "r" in spec.access:
        if calls_user_code or not node.calls_user_code:
            _look(values, node)
        if place.path:
            kind = kind_of(part(place, node.value))
    fields: dict[str, Value | None] = {
        "type": Word(kind),
        "access": Word(_access(node, caller)),
        "unit": spec.unit or None,
        "min": spec.minimum,
        "max": spec.maximum,
        "step": spec.step,
        "choices": spec.choices or None,
        "warn": spec.warn,
        "alarm": spec.alarm,
        "doc": spec.doc or None,
        "functional": True if node.function is not None else None,
        "arguments": _arguments(node),
        "time": float(node.time),
        "quality": Word(node.quality),
        "severity": Word(spec.severity(node.value)) if spec.warn or spec.alarm else None,
        "revision": node.revision,
    }
    if isinstance(node.value, bytes):
        fields["size"] = len(node.value)
    if node.source is not None and calls_user_code:
        about = result_of(values.user_code.call(node.source.about))
        fields |= {key: each for key, each in about.items() if not isinstance(each, bytes)}
    children = [Element(key, {}, (), each) for key, each in fields.items() if each is not None]
    return Element("meta", {}, tuple(children))


def _arguments(node: PropertyNode) -> Value | None:
    """Return what an action takes, each as ``.parameters`` shows it."""
    given = node.function.parameters if node.function is not None else ()
    return tuple(each.described() for each in given) or None


def _access(node: PropertyNode, caller: Requester) -> str:
    access = "rw" if node.function is not None else node.spec.access
    return access if caller.may("SET", node.name) else access.replace("w", "") or access


def _look(values: LiveValues, node: PropertyNode) -> None:
    """Update time, quality and revision to the present value, where it can be had."""
    try:
        values.look(node) if node.source else values.value_of(node)
    except PropertyError:
        node.quality = "bad"


def meta_field(described: Element, place: NameEntry) -> str:
    """Return one field of the element as text.

    Raises:
        PropertyError: ``unknown``: there is no such field.
    """
    field = described.find(place.field)
    if field is None or field.leaf is None:
        raise PropertyError("unknown", f"no such property: {place.name}.meta.{place.field}")
    return write(field.leaf)
