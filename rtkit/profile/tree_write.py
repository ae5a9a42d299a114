"""Converts a model to the tree of plain data of its YAML and JSON forms."""

from __future__ import annotations

from typing import Any

from rtkit.profile.common import Foreign, ForeignElement
from rtkit.profile.rts_model import OrderStep
from rtkit.profile.spec import DATE, FLAG, REAL, WHOLE, Attr, Child, ElementSpec
from rtkit.profile.tree_form import (
    CONDITION,
    FOREIGN_ATTRIBUTES,
    FOREIGN_ELEMENTS,
    WAITS,
    date_table,
    key_of,
)
from rtkit.profile.written import check_text, checked_name, format_value, in_order


def plain(value: Any, spec: ElementSpec, tag: str) -> dict[str, Any]:
    """Return a model as a table of keys, lists and scalars; `tag` is its element's name.

    Raises:
        Malformed: It holds what XML could not, so that no reader would take it.
    """
    made: dict[str, Any] = {}
    for attribute in spec.attributes:
        field = getattr(value, attribute.field)
        if field is not None:
            made[key_of(attribute.name, tag)] = _scalar(attribute, field)
    for part in in_order(spec, value):
        field = value if spec.wraps else getattr(value, part.field)
        if field is None or (part.is_many and not field):
            continue
        key = key_of(part.name, tag)
        content = [_child(part, each) for each in (field if part.is_many else (field,))]
        told = content if part.is_many else content[0]
        if spec.make is OrderStep and part.field in WAITS:
            made[CONDITION] = {key: told}
        else:
            made[key] = told
    return made | _foreign(getattr(value, spec.foreign_field))


def _child(part: Child, value: Any) -> Any:
    return check_text(value) if part.spec is None else plain(value, part.spec, part.name)


def _scalar(attribute: Attr, value: Any) -> Any:
    text = check_text(format_value(attribute, value))
    if attribute.kind == FLAG:
        return bool(value)
    if attribute.kind == REAL:
        return float(value)
    if attribute.kind == WHOLE:
        return int(value)
    date = date_table(text) if attribute.kind == DATE else None
    return text if date is None else date


def _foreign(foreign: Foreign) -> dict[str, Any]:
    made: dict[str, Any] = {}
    if foreign.attributes:
        made[FOREIGN_ATTRIBUTES] = _named(foreign.attributes)
    if foreign.elements:
        made[FOREIGN_ELEMENTS] = [_foreign_element(each) for each in foreign.elements]
    return made


def _foreign_element(element: ForeignElement) -> dict[str, Any]:
    made: dict[str, Any] = {"name": checked_name(element.name)}
    if element.attributes:
        made["attributes"] = _named(element.attributes)
    if element.text:
        made["text"] = check_text(element.text)
    if element.tail:
        made["tail"] = check_text(element.tail)
    if element.children:
        made["children"] = [_foreign_element(each) for each in element.children]
    return made


def _named(attributes: tuple[tuple[str, str], ...]) -> dict[str, str]:
    return {checked_name(name): check_text(text) for name, text in attributes}
