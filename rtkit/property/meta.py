"""Builds ``.meta`` of a property: its declaration, and the state of its value."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.property import components
from rtkit.property.codes import PropertyError
from rtkit.property.registry import NameEntry
from rtkit.property.values import Element, Value, Word
from rtkit.property.writing import write

if TYPE_CHECKING:
    from rtkit.property.node import PropertyNode
    from rtkit.property.requests import Requester
    from rtkit.property.service import Service


def meta(
    service: Service,
    node: PropertyNode,
    caller: Requester,
    path: tuple[str, ...] = (),
    *,
    calls_user_code: bool = True,
) -> Element:
    """Return the element; for a part of a value it has the type of that part.

    Args:
        service: Whose property it is.
        node: The property.
        caller: Who asks: what it may not set is told as read-only.
        path: Of the part.
        calls_user_code: It is read anew even where that takes user code.

    Raises:
        PropertyError: ``unknown``: there is no such part.
    """
    spec = node.spec
    kind = spec.type.name
    if node.function is not None:
        kind = "element"
    elif "r" in spec.access:
        if calls_user_code or not node.calls_user_code:
            _look(service, node)
        if path:
            kind = _kind_of_part(node, path)
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
        "time": float(node.time),
        "quality": Word(node.quality),
        "severity": Word(spec.severity(node.value)) if spec.warn or spec.alarm else None,
        "revision": node.revision,
    }
    children = [Element(key, {}, (), each) for key, each in fields.items() if each is not None]
    return Element("meta", {}, tuple(children))


def _access(node: PropertyNode, caller: Requester) -> str:
    access = "rw" if node.function is not None else node.spec.access
    return access if caller.may("SET", node.name) else access.replace("w", "") or access


def _look(service: Service, node: PropertyNode) -> None:
    """Update time, quality and revision to the present value, where it can be had."""
    try:
        service.value_of(node)
    except PropertyError:
        node.quality = "bad"


def _kind_of_part(node: PropertyNode, path: tuple[str, ...]) -> str:
    from rtkit.property.values import kind_of

    whole = node.value
    part = None
    if whole is not None and not isinstance(whole, bytes):
        part = components.get(whole, path, node.spec.labels)
    if part is None:
        raise PropertyError("unknown", f"no such property: {node.name}.{'.'.join(path)}")
    return kind_of(part)


def meta_field(described: Element, place: NameEntry) -> str:
    """Return one field of the element as text.

    Raises:
        PropertyError: ``unknown``: there is no such field.
    """
    field = described.find(place.field)
    if field is None or field.leaf is None:
        raise PropertyError("unknown", f"no such property: {place.name}.meta.{place.field}")
    return write(field.leaf)
