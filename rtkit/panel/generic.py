"""Makes widgets from the types of properties, for owners that describe none."""

from __future__ import annotations

from typing import Any

from rtkit.panel.description import Panel, panel_of
from rtkit.property.codes import PropertyError
from rtkit.property.property_spec import PropertySpec
from rtkit.property.types import Content, parse_type
from rtkit.property.values import Element, is_number, is_vector, kind_of
from rtkit.property.widgets import widget


def generic(name: str, meta: Element | None, value: Content | None) -> Panel:
    """Return the widget of a property.

    Args:
        name: Of the property.
        meta: What its owner tells of it, ``NAME.meta``; None for nothing.
        value: The present one, None if it is not known; without `meta` its type is that of it.
    """
    if meta is None:
        is_value = value is not None and not isinstance(value, bytes)
        type_name = kind_of(value) if is_value else "any"
        spec = PropertySpec(_type(type_name), "r")
    else:
        spec = _declared(meta)
    return panel_of(widget(name, spec, spec.access, value))


def _declared(meta: Element) -> PropertySpec:
    fields: dict[str, Any] = {each.name: each.leaf for each in meta.children}

    def number(key: str) -> float | None:
        return fields[key] if is_number(fields.get(key)) else None

    def items(key: str, size: int | None = None) -> Any:
        found = fields.get(key)
        is_good = isinstance(found, tuple) and (size is None or is_vector(found))
        return found if is_good and size in (None, len(found)) else None  # type: ignore[arg-type]

    access = str(fields.get("access", "r"))
    return PropertySpec(
        _type(str(fields.get("type", "any"))),
        access if access in ("r", "w", "rw") else "r",
        str(fields.get("unit", "")),
        number("min"),
        number("max"),
        number("step"),
        choices=items("choices") or (),
        warn=items("warn", 2),
        alarm=items("alarm", 2),
        doc=str(fields.get("doc", "")),
    )


def _type(name: str) -> Any:
    try:
        return parse_type(name)
    except PropertyError:
        return parse_type("any")
