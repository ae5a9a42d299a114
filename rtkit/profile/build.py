"""Make the model from a valid tree, along the tables of `rtkit.profile.spec`."""

from __future__ import annotations

from typing import Any

from rtkit.profile.common import Foreign, ForeignElement
from rtkit.profile.spec import Spec
from rtkit.profile.xmlnames import XSI_TYPE, split


def build(element: Any, spec: Spec) -> Any:
    """Return the model of `element`.

    Raises:
        KeyError: The tree is not valid.
        ValueError: The tree is not valid.
    """
    fields: dict[str, Any] = {}
    readers = spec.readers
    foreign_attributes: list[tuple[str, str]] = []
    for name, value in element.items():
        reader = readers.get(name)
        if reader is not None:
            field, read = reader
            fields[field] = value if read is None else read(value)
        elif name != XSI_TYPE:
            foreign_attributes.append((name, value))
    foreign_elements = _children(element, spec, fields) if len(element) else ()
    if foreign_attributes or foreign_elements:
        fields["foreign"] = Foreign(tuple(sorted(foreign_attributes)), foreign_elements)
    if spec.tag_field is not None:
        fields[spec.tag_field] = split(element.tag)[1]
    return spec.make(**fields)


def _children(element: Any, spec: Spec, fields: dict[str, Any]) -> tuple[ForeignElement, ...]:
    index = spec.index
    foreign: list[ForeignElement] = []
    for item in element:
        slot = index.get(item.tag)
        if slot is None:
            foreign.append(_foreign(item, is_top=True))
            continue
        _, (field, _name, inner, is_many, _least) = slot
        made = build(item, inner) if inner is not None else (item.text or "")
        if not is_many:
            fields[field] = made
        elif field in fields:
            fields[field].append(made)
        else:
            fields[field] = [made]
    for name in spec.many_fields:
        if name in fields:
            fields[name] = tuple(fields[name])
    return tuple(foreign)


def _foreign(item: Any, *, is_top: bool = False) -> ForeignElement:
    children = tuple(_foreign(below) for below in item)
    text = item.text if not children else _unless_blank(item.text)
    return ForeignElement(
        item.tag,
        tuple(sorted(item.items())),
        text or None,
        children,
        None if is_top else _unless_blank(item.tail),
    )


def _unless_blank(text: str | None) -> str | None:
    return text if text and not text.isspace() else None
